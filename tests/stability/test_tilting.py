"""How far gravity may tilt, where it can be worked out by hand, and how that changes with the boxes."""

from __future__ import annotations

import math

import pytest
import torch
from torch import Tensor

from blockstab.boxes.box import Boxes
from blockstab.stability.tilting import Tilt, least_tilt
from blockstab.testing.worlds import Block, build
from tests.stability.touching import touching


def tilt(world: tuple[Block, ...], friction: float = 0.7) -> Tilt:
    boxes, movable = build(*world)
    return least_tilt(boxes, movable, touching(boxes, movable), friction)


@pytest.mark.parametrize(("wide", "tall"), [(0.1, 0.4), (0.2, 0.3), (0.3, 0.2)])
def test_a_block_that_does_not_slip_may_tilt_until_its_middle_is_over_an_edge(wide, tall):
    found = tilt((Block(0, 0, wide, tall, d=2.0),), friction=10.0)
    assert float(found.degrees) == pytest.approx(math.degrees(math.atan(wide / tall)), abs=1e-6)
    assert found.direction.abs().tolist() == pytest.approx([1.0, 0.0], abs=1e-6)


def test_a_pyramid_of_friction_is_narrowest_between_its_edges():
    found = tilt((Block(0, 0, 0.1, 0.1),), friction=0.3)
    assert float(found.degrees) == pytest.approx(math.degrees(math.atan(0.3 / math.sqrt(2))), abs=1e-6)


def test_the_margin_of_a_scene_is_that_of_its_weakest_part_and_nothing_where_something_falls():
    weak, strong = Block(0, 0, 0.05, 0.3, d=0.2), Block(1, 0, 0.3, 0.1, d=0.3)
    assert float(tilt((weak, strong)).degrees) == pytest.approx(float(tilt((weak,)).degrees), abs=1e-6)
    assert tilt((weak, Block(1, 0.5, 0.1, 0.1))).degrees == 0.0
    assert tilt((Block(0, 0, 0.1, 0.1, fixed=True),)).degrees == 90.0


def test_the_gradient_is_the_change_of_the_margin():
    # Turned about the vertical and of odd sizes, so that no two bounds are equally near.
    boxes, movable = build(Block(0, 0, 0.21, 0.1, d=0.3), Block(0.03, 0.1, 0.13, 0.17, z=0.02, d=0.19))
    movable = torch.tensor([False, True])

    def degrees(center: Tensor, half_extent: Tensor) -> Tensor:
        moved = Boxes(boxes.center + center, boxes.rotation, boxes.half_extent + half_extent)
        return least_tilt(moved, movable, touching(moved, movable), friction=3.0).degrees

    # What moves the two together or apart would end the contact: only what keeps it is varied.
    def kept(change: Tensor) -> Tensor:
        x, z, wide, deep, taller = change
        center = torch.zeros(2, 3, dtype=torch.float64)
        center = center + torch.stack([torch.stack([x * 0, x * 0, x * 0]), torch.stack([x, taller, z])])
        half = torch.stack([torch.stack([x * 0, x * 0, x * 0]), torch.stack([wide, taller, deep])])
        return degrees(center, half)

    start = torch.zeros(5, dtype=torch.float64, requires_grad=True)
    assert torch.autograd.gradcheck(kept, (start,), eps=1e-6, atol=1e-3, rtol=1e-4)
    gradient = torch.autograd.grad(kept(start), start)[0]
    assert float(gradient[4]) < 0
