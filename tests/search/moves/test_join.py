"""Joins: neighbours become one, those first whose union looks like an object by itself."""

from __future__ import annotations

from collections import Counter

from blockstab.features.pairwise import pairs_of
from blockstab.search.moves.join import Join
from tests.search.moves.starts import STARTS, problem, rating
from tests.search.watched import seeded

ALL = 10**6  # more than there are


def test_every_pair_of_neighbouring_objects_can_be_joined_and_no_other():
    for start, now in STARTS.items():
        place = now.segments.index
        expected = {now.merge(place(one), place(other)) for one, other in pairs_of(rating(start).scene)}
        assert set(Join()(rating(start), problem(), ALL, seeded(0))) == expected


def test_pieces_of_a_block_are_joined_more_often_than_two_blocks():
    truth, now = STARTS["truth"].segments[1:], STARTS["pieces"]
    drawn = Counter(
        next(iter(set(result.segments) - set(now.segments)))
        for seed in range(200)
        for result in Join()(rating("pieces"), problem(), 1, seeded(seed))
    )
    right = {s: n for s, n in drawn.items() if any(s <= block for block in truth)}
    assert sum(right.values()) > sum(drawn.values()) / 2
