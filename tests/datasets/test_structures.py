"""Structures of blocks stand as they were meant to."""

from __future__ import annotations

from collections.abc import Callable

import pytest
import torch

from blockstab.boxes.box import checked
from blockstab.boxes.separation import separation
from blockstab.datasets.physics import settle
from blockstab.datasets.structures import STRUCTURES, Block, about_up, as_boxes
from tests.tolerance import EXACT

Structure = Callable[[torch.Generator], list[Block]]
every_structure = pytest.mark.parametrize(
    "structure", dict.fromkeys(STRUCTURES), ids=lambda s: s.__name__.strip("_")
)


@every_structure
def test_nothing_overlaps_and_all_sides_are_6_to_24_cm(
    structure: Structure, generator: torch.Generator
) -> None:
    for _ in range(20):
        boxes = checked(as_boxes(structure(generator)))
        assert boxes.half_extent.min() >= 0.03 - EXACT
        assert boxes.half_extent.max() <= 0.12 + EXACT
        assert boxes.corners()[..., 1].min() > 0
        first, second = torch.combinations(torch.arange(len(boxes)), 2).unbind(dim=1)
        assert (separation(boxes, first, second).gap > 0).all()


@every_structure
def test_a_structure_stays_as_it_was_put(structure: Structure, generator: torch.Generator) -> None:
    pytest.importorskip("mujoco", reason="the extra `sim` is not installed")
    for _ in range(5):
        boxes = as_boxes(structure(generator))
        resting = settle(boxes)
        assert resting is not None
        assert float((resting.center - boxes.center).norm(dim=1).max()) < 0.015


def test_a_quarter_turn_about_up_takes_z_to_x() -> None:
    turn = about_up(torch.tensor(torch.pi / 2, dtype=torch.float64))
    expected = torch.tensor([1.0, 0.0, 0.0], dtype=torch.float64)
    assert torch.allclose(turn[:, 2], expected, atol=EXACT)
