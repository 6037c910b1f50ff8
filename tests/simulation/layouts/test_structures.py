"""Structures of blocks stand as they were meant to."""

from __future__ import annotations

import pytest
import torch

from blockstab.boxes.box import Boxes, checked
from blockstab.boxes.separation import separation
from blockstab.simulation.layouts.placing import LIFT, Structure, lifted
from blockstab.simulation.layouts.structures import STRUCTURES, counterweight, single
from blockstab.simulation.physics.settling import falls, settle
from tests.tolerance import EXACT

every_structure = pytest.mark.parametrize("structure", STRUCTURES, ids=lambda s: s.__name__)


def gaps(boxes: Boxes) -> torch.Tensor:
    first, second = torch.combinations(torch.arange(len(boxes)), 2).unbind(dim=1)
    return separation(boxes, first, second).gap


@every_structure
def test_blocks_are_4_to_24_cm_and_planks_from_15_mm(
    structure: Structure, generator: torch.Generator
) -> None:
    for _ in range(20):
        pile = structure(generator)
        boxes = checked(pile.boxes())
        thinnest = [0.0075 if solid.style == "plank" else 0.02 for solid in pile.solids]
        assert (boxes.half_extent.amin(dim=1) >= torch.tensor(thinnest) - EXACT).all()
        assert boxes.half_extent.max() <= 0.12 + EXACT


@every_structure
def test_every_block_touches_the_table_or_another_and_none_overlap(
    structure: Structure, generator: torch.Generator
) -> None:
    for _ in range(20):
        boxes = structure(generator).boxes()
        lowest = boxes.corners()[..., 1].amin(dim=1)
        assert lowest.min() == pytest.approx(0.0, abs=EXACT)
        if len(boxes) == 1:
            continue
        assert gaps(boxes).min() > -EXACT
        index = torch.cartesian_prod(torch.arange(len(boxes)), torch.arange(len(boxes)))
        first, second = index[index[:, 0] != index[:, 1]].unbind(dim=1)
        touching = separation(boxes, first, second).gap.view(len(boxes), -1).amin(dim=1) < EXACT
        assert (touching | (lowest < EXACT)).all()


@every_structure
def test_a_lifted_structure_hangs_free_by_at_most_a_centimetre(
    structure: Structure, generator: torch.Generator
) -> None:
    for _ in range(20):
        pile = structure(generator)
        free = lifted(pile)
        up = free.center - pile.center
        assert up[:, 1].min() >= LIFT - EXACT
        assert up.max() < 0.01
        assert len(free) == 1 or gaps(free.boxes()).min() > -EXACT


@every_structure
def test_a_structure_stays_as_it_was_put(structure: Structure, generator: torch.Generator) -> None:
    pytest.importorskip("mujoco", reason="the extra `sim` is not installed")
    for _ in range(3):
        pile = structure(generator)
        resting = settle(lifted(pile))
        assert resting is not None
        assert float((resting.center - pile.center).norm(dim=1).max()) < 0.015


def test_the_beam_falls_without_its_counterweight(generator: torch.Generator) -> None:
    pytest.importorskip("mujoco", reason="the extra `sim` is not installed")
    for _ in range(5):
        resting = settle(lifted(counterweight(generator)))
        assert resting is not None
        assert falls(resting)[2].tolist() == [False, True, False]


def test_something_falls_without_something_else_in_every_structure_of_several(
    generator: torch.Generator,
) -> None:
    pytest.importorskip("mujoco", reason="the extra `sim` is not installed")
    for structure in (each for each in STRUCTURES if each is not single):
        resting = settle(lifted(structure(generator)))
        assert resting is not None
        assert falls(resting).any()
