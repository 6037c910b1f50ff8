"""Random splits: worse objects are drawn more often, background never."""

from __future__ import annotations

import pytest
import torch

from blockstab.search.moves.split import Split
from tests.search.moves.row import DRAWS, PAIRS, SHARES, halves, rated, shares, splitting


@pytest.mark.parametrize("scale", [1.0, 20.0])
def test_segments_of_higher_potential_are_split_more_often(generator, scale):
    rating = rated([9.0, 0.0 * scale, 0.5 * scale, 1.0 * scale], [0.0] * 3)
    start = rating.scene.segmentation
    outcomes = [start.replace(k, halves(PAIRS[k])) for k in (1, 2, 3)]
    found = shares(Split()(rating, splitting(), DRAWS, generator), outcomes)
    assert found == pytest.approx(SHARES, abs=0.02)


def test_equal_potentials_are_drawn_equally(generator):
    rating = rated([0.3] * 4, [0.3] * 3)
    outcomes = [rating.scene.segmentation.replace(k, halves(PAIRS[k])) for k in (1, 2, 3)]
    found = shares(Split()(rating, splitting(), DRAWS, generator), outcomes)
    assert found == pytest.approx([1 / 3] * 3, abs=0.02)


def test_single_atoms_are_not_split(generator):
    segments = [frozenset({0, 1}), frozenset({2}), frozenset({3, 4}), frozenset({5})]
    results = Split()(rated([9.0, 1.0, 0.0, 1.0], [0.0] * 3, segments), splitting(), 20, generator)
    assert {one.segments for one in results} == {
        (segments[0], segments[1], frozenset({3}), frozenset({4}), segments[3])
    }


def test_where_nothing_can_be_split_nothing_is_proposed(generator):
    segments = [frozenset({0, 1}), frozenset({2}), frozenset({3}), frozenset({4})]
    assert Split()(rated([1.0] * 4, [0.0] * 3, segments), splitting(), 5, generator) == []


def test_a_segment_that_does_not_fall_apart_is_left_alone(generator):
    stuck = splitting(lambda segment: None)
    assert Split()(rated([1.0] * 4, [0.0] * 3), stuck, 5, generator) == []


@pytest.mark.parametrize("count", [1, 5])
def test_so_many_splits_are_drawn(generator, count):
    assert len(Split()(rated([1.0] * 4, [0.0] * 3), splitting(), count, generator)) == count


def test_another_seed_draws_other_splits():
    rating = rated([0.0, 0.1, 0.2, 0.3], [0.3, 0.2, 0.1])
    one, other = (Split()(rating, splitting(), 9, torch.Generator().manual_seed(seed)) for seed in (1, 2))
    assert one != other
