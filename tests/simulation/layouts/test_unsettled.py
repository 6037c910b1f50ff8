"""Piles that may or may not stand."""

from __future__ import annotations

from collections.abc import Callable

import pytest
import torch

from blockstab.boxes.separation import separation
from blockstab.simulation.layouts.unsettled import DOUBTFUL, placed_unsettled
from blockstab.simulation.physics.settling import moves
from blockstab.simulation.physics.solids import Pile
from tests.tolerance import EXACT

Doubtful = Callable[[torch.Generator, float], Pile]
every_doubtful = pytest.mark.parametrize("structure", DOUBTFUL, ids=lambda s: s.__name__.strip("_"))


@every_doubtful
def test_the_boxes_of_a_structure_touch_and_do_not_overlap(
    structure: Doubtful, generator: torch.Generator
) -> None:
    for margin in torch.linspace(-0.3, 0.3, 40).tolist():
        boxes = structure(generator, margin).boxes()
        first, second = torch.combinations(torch.arange(len(boxes)), 2).unbind(dim=1)
        assert separation(boxes, first, second).gap.min() == pytest.approx(0.0, abs=EXACT)


@every_doubtful
@pytest.mark.parametrize("margin", [0.05, 0.3, -0.05, -0.3])
def test_what_acts_outside_the_edge_tips_and_what_acts_inside_holds(
    structure: Doubtful, margin: float, generator: torch.Generator
) -> None:
    pytest.importorskip("mujoco", reason="the extra `sim` is not installed")
    for _ in range(3):
        assert bool(moves(structure(generator, margin)).any()) == (margin < 0)


def test_piles_have_3_to_10_boxes_in_exact_contact_that_do_not_overlap(generator: torch.Generator) -> None:
    counts = set()
    for _ in range(30):
        pile = placed_unsettled(generator)
        counts.add(len(pile))
        assert {solid.kind for solid in pile.solids} == {"box"}
        first, second = torch.combinations(torch.arange(len(pile)), 2).unbind(dim=1)
        gap = separation(pile.boxes(), first, second).gap
        assert gap.min() == pytest.approx(0.0, abs=EXACT)
        assert pile.boxes().corners()[..., 1].min() == pytest.approx(0.0, abs=EXACT)
    assert min(counts) >= 3
    assert max(counts) <= 10
    assert len(counts) >= 5


def test_something_moves_in_about_half_of_the_piles() -> None:
    pytest.importorskip("mujoco", reason="the extra `sim` is not installed")
    piles = [placed_unsettled(torch.Generator().manual_seed(seed)) for seed in range(30)]
    assert 10 <= sum(bool(moves(pile).any()) for pile in piles) <= 20


def test_equal_seeds_make_equal_piles() -> None:
    first, second = (placed_unsettled(torch.Generator().manual_seed(3)) for _ in range(2))
    assert torch.equal(first.center, second.center)
    assert torch.equal(first.rotation, second.rotation)
