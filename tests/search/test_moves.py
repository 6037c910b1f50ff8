"""Random splits and merges: worse ones are drawn more often, background never."""

from __future__ import annotations

from collections import Counter
from dataclasses import replace

import pytest
import torch
from torch import Tensor

from blockstab.energy import Rating
from blockstab.features.pairwise import boundaries
from blockstab.search.moves import merge_moves, split_moves
from blockstab.segments.segmentation import Segment, Segmentation
from tests.box_scene import scene_of
from tests.worlds import Block

TABLE = Block(0, -0.1, 4.0, 0.1, d=4.0, fixed=True)
ROW = (TABLE, *(Block(0.3 * k, 0, 0.1, 0.1) for k in range(3)))
PAIRS = [frozenset({2 * k, 2 * k + 1}) for k in range(4)]  # atoms of the table and the three blocks
DRAWS = 6000
SHARES = [0.05 / 1.65, 0.55 / 1.65, 1.05 / 1.65]  # for potentials 0, 1/2 and 1: linear, but never zero


def rated(unary: list[float], pairwise: list[float], segments: list[Segment] | None = None) -> Rating:
    """The table and three blocks with these potentials; two atoms each unless `segments` says otherwise."""
    scene = replace(scene_of(*ROW), segmentation=Segmentation(tuple(segments or PAIRS)))
    return Rating(scene, torch.tensor(unary), torch.tensor(pairwise), 0.0)


def halves(segment: Segment) -> tuple[Segment, Segment]:
    first = frozenset({min(segment)})
    return first, segment - first


def shares(results: list[Segmentation], outcomes: list[Segmentation]) -> list[float]:
    counted = Counter(results)
    assert counted.keys() <= set(outcomes)
    return [counted[outcome] / len(results) for outcome in outcomes]


@pytest.mark.parametrize("scale", [1.0, 20.0])
def test_segments_of_higher_potential_are_split_more_often(generator, scale):
    rating = rated([9.0, 0.0 * scale, 0.5 * scale, 1.0 * scale], [0.0] * 3)
    start = rating.scene.segmentation
    outcomes = [start.replace(k, halves(PAIRS[k])) for k in (1, 2, 3)]
    found = shares(split_moves(rating, halves, DRAWS, generator), outcomes)
    assert found == pytest.approx(SHARES, abs=0.02)


@pytest.mark.parametrize("scale", [1.0, 20.0])
def test_pairs_of_higher_potential_are_merged_more_often(generator, scale):
    rating = rated([0.0] * 4, [0.0 * scale, 0.5 * scale, 1.0 * scale])
    first, second = boundaries(rating.scene)
    outcomes = [rating.scene.segmentation.merge(int(a), int(b)) for a, b in zip(first, second, strict=True)]
    found = shares(merge_moves(rating, DRAWS, generator), outcomes)
    assert found == pytest.approx(SHARES, abs=0.02)


def test_equal_potentials_are_drawn_equally(generator):
    rating = rated([0.3] * 4, [0.3] * 3)
    outcomes = [rating.scene.segmentation.replace(k, halves(PAIRS[k])) for k in (1, 2, 3)]
    assert shares(split_moves(rating, halves, DRAWS, generator), outcomes) == pytest.approx(
        [1 / 3] * 3, abs=0.02
    )


def test_single_atoms_are_not_split(generator):
    segments = [frozenset({0, 1}), frozenset({2}), frozenset({3, 4}), frozenset({5})]
    results = split_moves(rated([9.0, 1.0, 0.0, 1.0], [0.0] * 3, segments), halves, 20, generator)
    assert {one.segments for one in results} == {
        (segments[0], segments[1], frozenset({3}), frozenset({4}), segments[3])
    }


def test_where_nothing_can_move_nothing_is_proposed(generator):
    segments = [frozenset({0, 1}), frozenset({2}), frozenset({3}), frozenset({4})]
    assert split_moves(rated([1.0] * 4, [0.0] * 3, segments), halves, 5, generator) == []
    alone = scene_of(TABLE, Block(0, 0, 0.1, 0.1))
    assert merge_moves(Rating(alone, torch.zeros(2), torch.zeros(0), 0.0), 5, generator) == []


def test_a_segment_that_does_not_fall_apart_is_left_alone(generator):
    assert split_moves(rated([1.0] * 4, [0.0] * 3), lambda segment: None, 5, generator) == []


@pytest.mark.parametrize("count", [1, 5])
def test_so_many_moves_are_drawn(generator, count):
    rating = rated([1.0] * 4, [0.0] * 3)
    assert len(split_moves(rating, halves, count, generator)) == count
    assert len(merge_moves(rating, count, generator)) == count


def test_the_same_seed_draws_the_same_moves():
    rating = rated([0.0, 0.1, 0.2, 0.3], [0.3, 0.2, 0.1])

    def drawn(seed: int) -> list[Segmentation]:
        generator = torch.Generator().manual_seed(seed)
        return [*split_moves(rating, halves, 9, generator), *merge_moves(rating, 9, generator)]

    assert drawn(1) == drawn(1)
    assert drawn(1) != drawn(2)


def test_moves_leave_global_randomness_alone(generator):
    before: Tensor = torch.get_rng_state()
    split_moves(rated([1.0] * 4, [0.0] * 3), halves, 5, generator)
    merge_moves(rated([1.0] * 4, [0.0] * 3), 5, generator)
    assert torch.equal(torch.get_rng_state(), before)
