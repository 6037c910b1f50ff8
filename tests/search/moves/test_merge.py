"""Random merges: worse boundaries are drawn more often, those of background never."""

from __future__ import annotations

import pytest
import torch

from blockstab.energy import Rating
from blockstab.features.pairwise import neighbour_pairs
from blockstab.search.moves.merge import Merge
from blockstab.segments.segmentation import Segmentation
from blockstab.testing.worlds import Block
from tests.box_scene import scene_of
from tests.search.moves.row import DRAWS, SHARES, TABLE, rated, shares, splitting


def outcomes(rating: Rating) -> list[Segmentation]:
    first, second = neighbour_pairs(rating.scene)
    return [rating.scene.segmentation.merge(int(a), int(b)) for a, b in zip(first, second, strict=True)]


@pytest.mark.parametrize("scale", [1.0, 20.0])
def test_pairs_of_higher_potential_are_merged_more_often(generator, scale):
    rating = rated([0.0] * 4, [0.0 * scale, 0.5 * scale, 1.0 * scale])
    found = shares(Merge()(rating, splitting(), DRAWS, generator), outcomes(rating))
    assert found == pytest.approx(SHARES, abs=0.02)


def test_equal_potentials_are_drawn_equally(generator):
    rating = rated([0.3] * 4, [0.3] * 3)
    found = shares(Merge()(rating, splitting(), DRAWS, generator), outcomes(rating))
    assert found == pytest.approx([1 / 3] * 3, abs=0.02)


def test_where_no_objects_meet_nothing_is_proposed(generator):
    alone = scene_of(TABLE, Block(0, 0, 0.1, 0.1))
    rating = Rating(alone, torch.zeros(2), torch.zeros(0), torch.tensor(0.0))
    assert Merge()(rating, splitting(), 5, generator) == []


@pytest.mark.parametrize("count", [1, 5])
def test_so_many_merges_are_drawn(generator, count):
    assert len(Merge()(rated([1.0] * 4, [0.0] * 3), splitting(), count, generator)) == count


def test_another_seed_draws_other_merges():
    rating = rated([0.0, 0.1, 0.2, 0.3], [0.3, 0.2, 0.1])
    one, other = (Merge()(rating, splitting(), 9, torch.Generator().manual_seed(seed)) for seed in (1, 2))
    assert one != other
