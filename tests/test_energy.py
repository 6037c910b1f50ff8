"""Eq. 2 by hand, and that it is a function of the partition and of nothing else."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import pytest
import torch

from blockstab.energy import NEUTRAL, Energy
from blockstab.features.appearances import Appearances
from blockstab.features.pairwise import PAIRWISE_COLUMNS
from blockstab.features.unary import UNARY_COLUMNS
from blockstab.scene import Scene
from blockstab.view import View
from models.checkpoint import Potentials
from models.heads import LinearHead, MLPHead
from tests import worlds
from tests.box_scene import alike, scene_of
from tests.synthetic import BLOCKS, interpreter, photograph, variants, view_of
from tests.tolerance import EXACT
from tests.toy_potentials import random_potentials, toy_potentials
from tests.worlds import Block

# Potentials that are one feature each, so that sums can be done by hand.
ENERGY = Energy(
    lambda rows: rows[:, UNARY_COLUMNS.index("visible_share")],
    lambda rows: rows[:, PAIRWISE_COLUMNS.index("center_distance")],
    alike,
)
ROW = (Block(0, 0, 0.1, 0.1), Block(0.3, 0, 0.1, 0.1), Block(0.9, 0, 0.1, 0.1))


def test_energy_is_the_mean_over_segments_plus_the_mean_over_boundaries():
    scene = replace(scene_of(*ROW), visible_share=torch.tensor([0.2, 0.9, 0.7], dtype=torch.float64))
    apart = replace(scene, pairs=replace(scene.pairs, neighbours=torch.tensor([True, False, True])))
    (rating,) = ENERGY([apart])
    assert rating.unary.tolist() == [0.2, 0.9, 0.7]
    assert rating.pairwise.tolist() == pytest.approx([0.3, 0.6])
    assert rating.energy == pytest.approx((0.2 + 0.9 + 0.7) / 3 + (0.3 + 0.6) / 2, abs=EXACT)
    assert rating.scene is apart


def test_background_takes_no_part_in_either_mean():
    table = Block(0, -0.1, 4.0, 0.1, d=4.0, fixed=True)
    shares = torch.tensor([0.5, 0.2, 0.9, 0.7], dtype=torch.float64)
    with_table = replace(scene_of(table, *ROW), visible_share=shares)
    without = replace(scene_of(*ROW), visible_share=shares[1:])
    rated, bare = ENERGY([with_table, without])
    assert rated.energy == bare.energy
    assert len(rated.unary) == 4  # but it is rated


@pytest.mark.parametrize(("fixed", "energy"), [(False, 0.75 + NEUTRAL), (True, NEUTRAL + NEUTRAL)])
def test_a_mean_over_nothing_is_neither_good_nor_bad(fixed, energy):
    (rating,) = ENERGY([scene_of(Block(0, 0, 0.1, 0.1, fixed=fixed))])
    assert rating.energy == energy


def test_no_scene_has_no_rating():
    assert ENERGY([]) == []


@pytest.mark.parametrize("head", [LinearHead, MLPHead])
def test_the_rating_of_a_scene_does_not_depend_on_the_scenes_rated_with_it(head):
    potentials = random_potentials(head)
    energy = Energy(potentials.unary, potentials.pairwise, alike)
    scenes = [scene_of(*blocks) for blocks in (worlds.BRIDGE, ROW, ROW[:1], worlds.COUNTERWEIGHT)] * 9
    for together, scene in zip(energy(scenes), scenes, strict=True):
        (alone,) = energy([scene])
        assert torch.equal(alone.unary, together.unary)
        assert torch.equal(alone.pairwise, together.pairwise)
        assert alone.energy == together.energy


@cache
def view() -> View:
    """Blocks on a table."""
    return view_of(photograph(*BLOCKS))


@cache
def scenes_by_order() -> dict[str, list[Scene]]:
    """The same segmentations, understood in different company."""
    many, grown = variants(view(), 20), interpreter(view())
    return {
        "together": interpreter(view())(many),
        "backwards": interpreter(view())(many[::-1])[::-1],
        "in turn": [grown([one])[0] for one in many],
        "each anew": [interpreter(view())([one])[0] for one in many],
    }


def looking_at_the_blocks(potentials: Potentials) -> Energy:
    """Eq. 2 for their image, of which nothing has been looked at yet."""
    appearance = Appearances(view().percept, view().atoms)
    return Energy(potentials.unary, potentials.pairwise, appearance)


@pytest.mark.parametrize("head", [LinearHead, MLPHead])
def test_the_same_partition_has_the_same_energy_in_any_order_of_evaluation(head):
    potentials = random_potentials(head)
    expected = [rating.energy for rating in looking_at_the_blocks(potentials)(scenes_by_order()["together"])]
    for order, scenes in scenes_by_order().items():
        energy = looking_at_the_blocks(potentials)
        assert [energy([scene])[0].energy for scene in scenes] == expected, order
        energy = looking_at_the_blocks(potentials)
        assert [rating.energy for rating in energy(scenes[::-1])][::-1] == expected, order


def test_how_segments_look_counts():
    scenes, potentials = scenes_by_order()["together"], random_potentials()
    blind = Energy(potentials.unary, potentials.pairwise, alike)
    for one, other in zip(looking_at_the_blocks(potentials)(scenes), blind(scenes), strict=True):
        assert torch.equal(one.unary, other.unary)
        assert bool((one.pairwise != other.pairwise).all())


def test_convention_lower_energy_is_better():
    truth, *spoilt = interpreter(view())(variants(view(), 12))
    best, *worse = looking_at_the_blocks(toy_potentials())([truth, *spoilt])
    assert all(best.energy < rating.energy for rating in worse)
    assert bool((best.unary[~truth.background] < worse[0].unary.amax()).all())
