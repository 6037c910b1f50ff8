"""The preset `objects`, before and after physics."""

from __future__ import annotations

import pytest
import torch

from blockstab.boxes.box import checked
from blockstab.boxes.separation import separation
from blockstab.simulation.layouts.objects import STRUCTURES, arrange_objects, ball_in_bowl
from blockstab.simulation.layouts.placing import Structure, lifted
from blockstab.simulation.physics.contacts import contacts
from blockstab.simulation.physics.settling import settle


@pytest.mark.parametrize("structure", dict.fromkeys(STRUCTURES), ids=lambda s: s.__name__)
def test_no_two_bounding_boxes_overlap_but_those_of_a_bowl_and_what_is_in_it(
    structure: Structure, generator: torch.Generator
) -> None:
    for _ in range(15):
        pile = lifted(structure(generator))
        boxes = checked(pile.boxes())
        assert boxes.corners()[..., 1].min() > 0
        first, second = torch.combinations(torch.arange(len(pile)), 2).unbind(dim=1)
        overlap = separation(boxes, first, second).gap < -1e-9
        for i, j in zip(first[overlap], second[overlap], strict=True):
            assert {pile.solids[i].style, pile.solids[j].style} == {"bowl", "ball"}


def test_a_ball_let_go_in_a_bowl_comes_to_rest_in_it(generator: torch.Generator) -> None:
    pytest.importorskip("mujoco", reason="the extra `sim` is not installed")
    for _ in range(3):
        resting = settle(lifted(ball_in_bowl(generator)))
        assert resting is not None
        bowl, ball = resting.center[-2:]
        assert float((ball - bowl)[[0, 2]].norm()) < 0.01
        assert float(contacts(resting).share[-3, -1]) == pytest.approx(1.0, abs=0.02)


def test_piles_have_5_to_15_things_of_many_kinds(generator: torch.Generator) -> None:
    piles = [arrange_objects(generator) for _ in range(20)]
    assert min(map(len, piles)) >= 5
    assert max(map(len, piles)) <= 15
    styles = {solid.style for pile in piles for solid in pile.solids}
    assert styles == {"block", "book", "carton", "tin", "can", "ball", "bowl", "bottle", "bracket"}
    for pile in piles:
        assert pile.boxes().corners()[..., [0, 2]].norm(dim=-1).max() < 0.45


def test_most_piles_come_to_rest_and_a_fifth_of_all_stand_on_another() -> None:
    pytest.importorskip("mujoco", reason="the extra `sim` is not installed")
    piles = [settle(arrange_objects(torch.Generator().manual_seed(seed))) for seed in range(6)]
    resting = [pile for pile in piles if pile is not None]
    assert len(resting) >= 4
    stacked = [(contacts(pile).share[:-1] >= 0.05).any(dim=0) for pile in resting]
    assert torch.cat(stacked).double().mean() >= 0.2


def test_equal_seeds_make_equal_piles() -> None:
    first, second = (arrange_objects(torch.Generator().manual_seed(5)) for _ in range(2))
    assert [solid.kind for solid in first.solids] == [solid.kind for solid in second.solids]
    assert torch.equal(first.center, second.center)
    assert torch.equal(first.rotation, second.rotation)
