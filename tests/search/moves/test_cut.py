"""Cuts and transfers: any part of the hierarchy that lies within an object, and any neighbour of it."""

from __future__ import annotations

import pytest

from blockstab.search.moves.cut import Cut, Transfer, inner_nodes
from blockstab.search.problem import MIN_SEGMENT_PX
from blockstab.segments.hierarchy import nodes
from blockstab.segments.segmentation import Segment
from tests.search.moves.starts import STARTS, problem, rating
from tests.search.watched import seeded

every_start = pytest.mark.parametrize("start", STARTS)
ALL = 10**6  # more than there are


def objects(start: str) -> list[Segment]:
    scene = rating(start).scene
    return [s for s, b in zip(scene.segmentation.segments, scene.background.tolist(), strict=True) if not b]


def parts(start: str) -> set[tuple[Segment, Segment]]:
    """Every object with every node in it, by brute force."""
    large = {n for n in nodes(problem().hierarchy) if problem().pixel_count(n) >= MIN_SEGMENT_PX}
    return {
        (whole, node)
        for whole in objects(start)
        for node in large
        if node < whole and problem().pixel_count(whole - node) >= MIN_SEGMENT_PX
    }


@every_start
def test_inner_nodes_are_all_proper_parts_that_leave_enough(start):
    found = [(whole, node) for _, whole, (node, rest) in inner_nodes(rating(start), problem())]
    assert set(found) == parts(start)
    assert len(found) == len(set(found))


@every_start
def test_any_node_of_the_hierarchy_in_an_object_can_be_cut_off(start):
    segmentation = rating(start).scene.segmentation
    expected = {
        segmentation.replace(segmentation.segments.index(whole), (node, whole - node))
        for whole, node in parts(start)
    }
    assert set(Cut()(rating(start), problem(), ALL, seeded(0))) == expected


def test_a_cut_reaches_what_a_split_at_the_top_does_not():
    # Of the heap, the hierarchy parts one block first; the others can be cut off at once all the same.
    found = {s for result in Cut()(rating("heap"), problem(), ALL, seeded(0)) for s in result.segments}
    top = problem().split(objects("heap")[0])
    assert top is not None
    blocks = set(STARTS["truth"].segments[1:]) & set(nodes(problem().hierarchy))
    assert len(blocks) > 1
    assert blocks <= found
    assert not blocks <= set(top)


@every_start
def test_a_transfer_keeps_the_number_of_segments_and_hands_one_node_to_a_neighbour(start):
    before = rating(start).scene.segmentation
    for result in Transfer()(rating(start), problem(), ALL, seeded(0)):
        assert len(result) == len(before)
        gone, new = set(before.segments) - set(result.segments), set(result.segments) - set(before.segments)
        assert len(gone) == len(new) == 2
        assert gone <= set(objects(start))
        (giver,) = (s for s in gone if any(n < s for n in new))
        (taker,) = gone - {giver}
        node = next(n for n in new if taker < n) - taker
        assert (giver, node) in parts(start)
        assert any(b in taker for a in node for b in problem().touching[a])


def test_every_neighbour_that_a_node_touches_can_take_it():
    now, held = STARTS["pieces"], objects("pieces")
    expected = {
        frozenset({whole - node, other | node})
        for whole, node in parts("pieces")
        for other in held
        if other != whole and any(b in other for a in node for b in problem().touching[a])
    }
    found = {
        frozenset(set(result.segments) - set(now.segments))
        for result in Transfer()(rating("pieces"), problem(), ALL, seeded(0))
    }
    assert expected
    assert found == expected
