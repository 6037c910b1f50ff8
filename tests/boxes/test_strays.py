"""Few points far from all others do not stretch a box; many do."""

from __future__ import annotations

import pytest
import torch
from torch import Tensor

from blockstab.boxes.box import Boxes
from blockstab.boxes.strays import without_strays


def cloud(generator: torch.Generator, strays: int, away: float) -> tuple[Tensor, Tensor]:
    """Points that fill a cube of 10 cm, and some that lie far beyond one face of it."""
    inside = torch.rand(1000, 3, generator=generator, dtype=torch.float64) * 0.1
    beyond = torch.rand(strays, 3, generator=generator, dtype=torch.float64) * 0.01
    beyond[:, 1] -= away
    points = torch.cat([inside, beyond, torch.full((50, 3), 9.0, dtype=torch.float64)])[None]
    return points, torch.tensor([1000 + strays])


def around(points: Tensor, count: Tensor) -> Boxes:
    real = points[0, : int(count)]
    low, high = real.amin(dim=0), real.amax(dim=0)
    return Boxes(((low + high) / 2)[None], torch.eye(3, dtype=torch.float64)[None], ((high - low) / 2)[None])


@pytest.mark.parametrize(("strays", "away"), [(2, 0.05), (10, 0.5), (100, 0.1), (200, 65.0)])
def test_strays_are_cut_off(strays, away, generator):
    points, count = cloud(generator, strays, away)
    cut = without_strays(around(points, count), points, count)
    assert torch.allclose(cut.half_extent, torch.full((1, 3), 0.05, dtype=torch.float64), atol=0.001)
    assert torch.allclose(cut.center, torch.full((1, 3), 0.05, dtype=torch.float64), atol=0.001)


def test_a_box_without_strays_stays_as_it_is(generator):
    points, count = cloud(generator, 0, 0.0)
    boxes = around(points, count)
    cut = without_strays(boxes, points, count)
    assert torch.equal(cut.center, boxes.center)
    assert torch.equal(cut.half_extent, boxes.half_extent)


def test_many_points_are_a_part_of_the_thing(generator):
    points, count = cloud(generator, 300, 0.2)
    boxes = around(points, count)
    assert torch.equal(without_strays(boxes, points, count).half_extent, boxes.half_extent)
