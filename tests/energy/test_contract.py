"""What every energy must keep to: it is a function of the partition and of nothing else."""

from __future__ import annotations

from functools import cache

import pytest
import torch

from blockstab.energy.overlap import expected_overlap
from blockstab.energy.paper import paper_energy
from blockstab.energy.truth import true_overlap
from blockstab.features.description import Described, Describer
from blockstab.proposals.search_input import SearchInput
from blockstab.scene.types import Scene
from blockstab.search.problem import EnergyFactory
from blockstab.segments.hierarchy import build_hierarchy
from blockstab.testing.photographs import BLOCKS, photograph
from models.potentials.heads import LinearHead, MLPHead
from tests.search.watched import in_scene
from tests.synthetic import builder, variants, view_of
from tests.tolerance import COMPANY
from tests.toy_potentials import random_potentials, toy_potentials

ENERGIES: list[EnergyFactory] = [expected_overlap, paper_energy, true_overlap]
every_energy = pytest.mark.parametrize("energy", ENERGIES)
every_head = pytest.mark.parametrize("head", [LinearHead, MLPHead])


@cache
def search_input() -> SearchInput:
    """Blocks on a table."""
    return view_of(photograph(*BLOCKS))


@cache
def scenes_by_order() -> dict[str, list[Scene]]:
    """The same segmentations, understood in different company."""
    many, grown = variants(search_input(), 12), builder(search_input())
    return {
        "together": builder(search_input())(many),
        "backwards": builder(search_input())(many[::-1])[::-1],
        "in turn": [grown([one])[0] for one in many],
        "each anew": [builder(search_input())([one])[0] for one in many],
    }


def describer() -> Describer:
    """Of the image, which has looked at nothing yet."""
    return Describer(
        search_input().observation,
        search_input().atoms,
        build_hierarchy(search_input().atoms),
        toy_potentials().background,
    )


@cache
def described() -> list[Described]:
    return describer()(scenes_by_order()["together"])


@every_head
@every_energy
def test_the_rating_of_a_scene_is_the_same_within_1e_9_whatever_scenes_are_rated_with_it(energy, head):
    rate = energy(random_potentials(head), search_input())
    for together, one in zip(rate(described() * 9), described(), strict=False):
        (alone,) = rate([one])
        torch.testing.assert_close(alone.unary, together.unary, rtol=0.0, atol=COMPANY)
        torch.testing.assert_close(alone.pairwise, together.pairwise, rtol=0.0, atol=COMPANY)
        torch.testing.assert_close(alone.energy, together.energy, rtol=0.0, atol=COMPANY)


@every_energy
def test_the_same_partition_has_the_same_energy_within_1e_9_in_any_order_of_evaluation(energy):
    rate = energy(random_potentials(), search_input())
    expected = pytest.approx([float(r.energy) for r in rate(described())], rel=0.0, abs=COMPANY)
    for order, scenes in scenes_by_order().items():
        describe = describer()
        assert [float(rate(describe([scene]))[0].energy) for scene in scenes] == expected, order
        describe = describer()
        assert [float(r.energy) for r in rate(describe(scenes[::-1]))][::-1] == expected, order


@every_energy
def test_a_rating_is_of_its_scene_with_a_potential_for_each_segment_and_boundary(energy):
    for rating, one in zip(energy(toy_potentials(), search_input())(described()), described(), strict=True):
        assert rating.scene is one.scene
        assert rating.unary.shape == (len(one.scene),)
        assert rating.pairwise.shape == (len(one.pairwise),)
        assert rating.energy.shape == ()
        assert rating.energy.dtype == torch.float64


@every_energy
def test_no_scene_has_no_rating(energy):
    assert energy(toy_potentials(), search_input())([]) == []


@pytest.mark.parametrize("energy", [in_scene, paper_energy, true_overlap])
def test_a_worse_segmentation_has_more_energy(energy):
    best, *worse = energy(toy_potentials(), search_input())(described())
    assert all(best.energy < rating.energy for rating in worse)
    assert float(best.unary[~best.scene.background].amax()) < max(float(r.unary.amax()) for r in worse)


@pytest.mark.parametrize("energy", [expected_overlap, paper_energy])
def test_how_segments_look_counts(energy):
    rate = energy(random_potentials(), search_input())
    for one in described():
        blind = Described(one.scene, one.unary, one.pairwise.clone(), one.lost)
        blind.pairwise[:, 12:] = 0.0
        (seen,), (unseen,) = rate([one]), rate([blind])
        assert torch.equal(seen.unary, unseen.unary)
        assert bool((seen.pairwise != unseen.pairwise).all())
