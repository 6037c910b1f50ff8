"""Random splits and merges that make bad segmentations of good ones."""

from __future__ import annotations

from itertools import chain

import pytest
import torch

from blockstab.segments.atoms import make_atoms
from blockstab.segments.segmentation import Segment, Segmentation
from models.spoiling import spoil

SIDE, ROWS, COLUMNS = 6, 8, 6
ATOMS = make_atoms(
    (1 + torch.arange(ROWS * COLUMNS).view(ROWS, COLUMNS))
    .repeat_interleave(SIDE, dim=0)
    .repeat_interleave(SIDE, dim=1),
    torch.zeros(ROWS * SIDE, COLUMNS * SIDE, dtype=torch.float64),
)
# The upper half is table; below, twelve objects of two atoms each.
TABLE = frozenset(range(24))
OBJECTS = frozenset(range(24, 48))
START = Segmentation((TABLE, *(frozenset({k, k + 1}) for k in range(24, 48, 2))))


def halves(segment: Segment) -> tuple[Segment, Segment] | None:
    first = frozenset({min(segment)})
    return (first, segment - first) if len(segment) > 1 else None


def spoilt(*kinds: str, seed: int = 0, start: Segmentation = START) -> Segmentation:
    generator = torch.Generator().manual_seed(seed)
    return spoil(start, OBJECTS, kinds, halves, ATOMS, generator)


KINDS = [("split",), ("merge",), ("split", "merge")]


@pytest.mark.parametrize("kinds", KINDS)
def test_background_is_never_touched(kinds):
    for seed in range(20):
        found = spoilt(*kinds, seed=seed)
        assert found.segments[0] == TABLE
        assert sorted(chain(*found.segments)) == list(range(48))


def test_between_one_and_the_share_of_the_segments_is_moved():
    splits = {len(spoilt("split", seed=seed)) - len(START) for seed in range(60)}
    merges = {len(START) - len(spoilt("merge", seed=seed)) for seed in range(60)}
    assert splits == merges == {1, 2, 3, 4}  # 30 % of twelve objects


def test_both_kinds_are_drawn_where_both_are_allowed():
    sizes = {len(spoilt("split", "merge", seed=seed)) - len(START) for seed in range(40)}
    assert min(sizes) < 0 < max(sizes)


def test_only_neighbours_are_merged():
    first, second = (index.tolist() for index in START.neighbours(ATOMS))
    possible = {START.merge(a, b) for a, b in zip(first, second, strict=True)}
    single = [
        found for found in (spoilt("merge", seed=seed) for seed in range(40)) if len(found) == len(START) - 1
    ]
    assert single
    assert set(single) <= possible


@pytest.mark.parametrize("kinds", KINDS)
def test_the_same_seed_spoils_alike(kinds):
    assert spoilt(*kinds, seed=4) == spoilt(*kinds, seed=4)
    assert len({spoilt(*kinds, seed=seed) for seed in range(10)}) > 1


@pytest.mark.parametrize("kinds", KINDS)
def test_where_nothing_can_move_nothing_changes(kinds):
    table = Segmentation((TABLE,))
    assert spoilt(*kinds, start=table) == table
    atoms = Segmentation((TABLE, frozenset({24})))
    assert spoilt(*kinds, start=atoms) == atoms


def test_the_start_stays_as_it_was():
    before = tuple(START.segments)
    spoilt("split", "merge")
    assert START.segments == before
