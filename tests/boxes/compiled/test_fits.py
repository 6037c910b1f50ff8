"""Boxes from machine code against the same steps in torch."""

from __future__ import annotations

import pytest
import torch
from torch import Tensor

from blockstab.boxes.box import Boxes
from blockstab.boxes.fitting import MinimumSurface
from blockstab.boxes.fitting_in_step import fit_in_step
from tests.seen_boxes import boxes_showing, seen_points
from tests.tolerance import EXACT

SETS, POINTS = 40, 900


def shown(faces: int) -> tuple[Tensor, Tensor, Tensor, Tensor]:
    """Points, counts, seeds, and an axis for each."""
    generator = torch.Generator().manual_seed(faces)
    points = seen_points(boxes_showing(faces, SETS, generator), POINTS, generator, 0.002)
    count = torch.randint(10, POINTS + 1, (SETS,), generator=generator)
    axis = torch.randn(SETS, 3, generator=generator, dtype=torch.float64)
    return points, count, torch.arange(SETS), torch.nn.functional.normalize(axis, dim=1)


def corners_apart(one: Boxes, other: Boxes) -> Tensor:
    """(N,) the furthest that a corner of one lies from the nearest corner of the other, metres."""
    return torch.cdist(one.corners(), other.corners()).amin(dim=2).amax(dim=1)


@pytest.mark.parametrize("follow", [False, True], ids=["free", "with an axis"])
@pytest.mark.parametrize("faces", [2, 3])
@pytest.mark.parametrize("settings", [MinimumSurface(), MinimumSurface(restarts=7, outlier_share=0.0)])
def test_boxes_are_those_of_the_steps_in_torch(settings, faces, follow):
    points, count, seed, axis = shown(faces)
    given = axis if follow else None
    fast, slow = settings(points, count, seed, given), fit_in_step(points, count, seed, settings, given)
    assert float(corners_apart(fast.boxes, slow.boxes).max()) < EXACT
    torch.testing.assert_close(fast.mean, slow.mean, rtol=0.0, atol=EXACT)
    torch.testing.assert_close(fast.variance, slow.variance, rtol=0.0, atol=EXACT)


@pytest.mark.parametrize("faces", [1, 2, 3])
def test_all_points_but_one_lie_on_the_same_faces(faces):
    points, count, seed, _ = shown(faces)
    count = count.clamp(min=100)
    fast, slow = MinimumSurface()(points, count, seed), fit_in_step(points, count, seed, MinimumSurface())
    same = corners_apart(fast.boxes, slow.boxes) < EXACT
    apart = (fast.visible_share - slow.visible_share).abs() * count
    # The point that two faces were laid through is as near to either.
    assert float(apart[same].max()) < 1.5
    assert int((apart[same] > 0.5).sum()) < 0.1 * SETS


def test_one_flat_face_has_the_sides_of_its_least_rectangle_either_way():
    # From which side the grid of angles starts is a choice: a few sides differ by less than its step.
    points, count, seed, _ = shown(1)
    fast, slow = MinimumSurface()(points, count, seed), fit_in_step(points, count, seed, MinimumSurface())
    assert int((corners_apart(fast.boxes, slow.boxes) < EXACT).sum()) > 0.8 * SETS
    area = [fits.boxes.half_extent.sort(dim=1).values[:, 1:].prod(dim=1) for fits in (fast, slow)]
    assert float((area[0] / area[1] - 1.0).abs().max()) < 0.02
