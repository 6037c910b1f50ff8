"""Random walks: each step one move from the last, whatever moves there are."""

from __future__ import annotations

from itertools import pairwise

import torch

from blockstab.search.moves.every import EVERY
from blockstab.search.moves.merge import Merge
from blockstab.search.moves.split import Split
from models.potentials.perturbing import walks
from tests.search.moves.starts import STARTS, problem, rating


def visited(moves=EVERY, steps=6, seed=0, start="truth"):
    generator = torch.Generator().manual_seed(seed)
    return [r.scene.segmentation for r in walks([rating(start)], problem(), moves, steps, generator)]


def test_every_step_is_one_move_from_the_one_before():
    path = [STARTS["pieces"], *visited((Split(), Merge()), steps=12, start="pieces")]
    assert len(path) > 5
    for before, after in pairwise(path):
        gone, new = set(before.segments) - set(after.segments), set(after.segments) - set(before.segments)
        assert sorted([len(gone), len(new)]) == [1, 2]


def test_a_walk_has_at_most_its_steps_and_leads_away():
    assert [len(visited(steps=n)) for n in (0, 1)] == [0, 1]
    path = visited(steps=6)
    assert 0 < len(path) <= 6
    assert STARTS["truth"] != path[0]


def test_where_no_move_is_possible_the_walk_stands_still():
    assert visited((Merge(),), start="heap") == []


def test_walks_go_side_by_side_each_from_its_own_start():
    generator = torch.Generator().manual_seed(3)
    starts = [rating("truth"), rating("pieces"), rating("truth")]
    found = walks(starts, problem(), (Merge(),), 1, generator)
    assert len(found) == 3
    for origin, one in zip(starts, found, strict=True):
        before, after = set(origin.scene.segmentation.segments), set(one.scene.segmentation.segments)
        assert len(before ^ after) == 3


def test_the_same_seed_walks_the_same_way_and_other_seeds_others():
    assert visited(seed=2) == visited(seed=2)
    assert len({tuple(visited(seed=k, steps=2)) for k in range(5)}) > 2


def test_all_kinds_of_moves_are_drawn():
    firsts = [next(iter(visited(steps=1, seed=k)), None) for k in range(40)]
    sizes = {len(one) - len(STARTS["truth"]) for one in firsts if one is not None}
    assert min(sizes) < 0 < max(sizes)
