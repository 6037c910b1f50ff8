"""How far boxes reach, and how far points are from their surface."""

from __future__ import annotations

import math

import pytest
import torch
from torch import Tensor

from blockstab.boxes.box import MIN_HALF_EXTENT
from blockstab.boxes.extent import enclose, flat_frame, surface_distance
from blockstab.boxes.plane_fits import Plane
from tests.seen_boxes import boxes_showing, random_turns, seen_points
from tests.tolerance import EXACT


def uniform(generator: torch.Generator, *shape: int) -> Tensor:
    """Numbers between -1 and 1."""
    return 2 * torch.rand(*shape, generator=generator, dtype=torch.float64) - 1


def test_without_outliers_a_box_reaches_to_its_outermost_points(generator: torch.Generator) -> None:
    boxes = boxes_showing(3, 10, generator)
    points = torch.cat([boxes.corners(), seen_points(boxes, 50, generator)], dim=1)
    present = torch.ones(10, 58, dtype=torch.bool)
    center, half = enclose(points, present, boxes.rotation[:, None], 0.0, boxes.center)
    assert float((center[:, 0] - boxes.center).abs().max()) < EXACT
    assert float((half[:, 0] - boxes.half_extent).abs().max()) < EXACT


@pytest.mark.parametrize("outlier_share", [0.0, 0.05, 0.2])
def test_no_more_than_the_outlier_share_is_left_outside(
    outlier_share: float, generator: torch.Generator
) -> None:
    points = torch.randn(6, 500, 3, generator=generator, dtype=torch.float64)
    count = torch.tensor([1, 7, 100, 119, 499, 500])
    present = torch.arange(500) < count[:, None]
    rotation = random_turns(24, generator).view(6, 4, 3, 3)
    center, half = enclose(points, present, rotation, outlier_share, points[:, 0])
    local = (points[:, None] - center[:, :, None]) @ rotation
    outside = (local.abs() > half[:, :, None] + EXACT).any(dim=-1) & present[:, None]
    assert bool((outside.sum(dim=-1) <= outlier_share * count[:, None]).all())
    if outlier_share:
        assert bool((outside.sum(dim=-1)[-1] > 0).all())


def test_a_stray_point_within_the_share_does_not_lengthen_the_box(generator: torch.Generator) -> None:
    points = 0.1 * uniform(generator, 1, 500, 3)
    points[0, 7] = torch.tensor([5.0, 5.0, 5.0])
    rotation = torch.eye(3, dtype=torch.float64)[None, None]
    _, half = enclose(points, torch.ones(1, 500, dtype=torch.bool), rotation, 0.05, points[:, 0])
    assert float(half.max()) < 0.1


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_a_flat_set_is_the_face_that_the_camera_sees_of_the_thinnest_box(
    side: float, generator: torch.Generator
) -> None:
    points = uniform(generator, 1, 100, 3) * torch.tensor([0.1, 0.0, 0.2])
    points[..., 1] = 0.7 * side
    rotation = torch.eye(3, dtype=torch.float64)[None, None]
    present = torch.ones(1, 100, dtype=torch.bool)
    center, half = enclose(points, present, rotation, 0.0, points.mean(dim=1))
    assert float(half[0, 0, 1]) == MIN_HALF_EXTENT
    assert float(center[0, 0, 1]) == pytest.approx(side * (0.7 + MIN_HALF_EXTENT), abs=EXACT)


@pytest.mark.parametrize(
    ("point", "distance"),
    [
        ([0.0, 0.0, 0.0], 0.1),  # the middle: to the nearest face
        ([0.0, 0.0, 0.27], 0.03),  # within, below one face
        ([0.1, 0.05, 0.1], 0.0),  # on a face
        ([0.1, 0.2, 0.3], 0.0),  # on a corner
        ([0.14, 0.0, 0.0], 0.04),  # off a face
        ([0.13, 0.24, 0.0], 0.05),  # off an edge
        ([-0.12, -0.23, 0.36], 0.07),  # off a corner
    ],
)
def test_distance_to_the_surface_of_a_box(point: list[float], distance: float) -> None:
    half = torch.tensor([0.1, 0.2, 0.3], dtype=torch.float64)
    found = surface_distance(torch.tensor(point, dtype=torch.float64), half)
    assert float(found) == pytest.approx(distance, abs=EXACT)


def test_distance_to_the_surface_is_that_to_the_nearest_of_many_surface_points(
    generator: torch.Generator,
) -> None:
    half = torch.tensor([0.1, 0.2, 0.3], dtype=torch.float64)
    grid = torch.linspace(-1, 1, 41, dtype=torch.float64)
    cube = torch.cartesian_prod(grid, grid, grid)
    surface = cube[(cube.abs() == 1).any(dim=1)] * half
    points = 0.4 * uniform(generator, 200, 3)
    nearest = torch.cdist(points, surface).amin(dim=1)
    found = surface_distance(points, half)
    assert bool((found <= nearest + EXACT).all())
    assert float((nearest - found).max()) < 0.01  # half the diagonal of the widest cell


@pytest.mark.parametrize("angle_deg", [0.0, 10.0, 44.0, 80.0])
def test_a_flat_face_gets_its_normal_and_the_sides_of_its_rectangle(
    angle_deg: float, generator: torch.Generator
) -> None:
    frame = random_turns(1, generator)[0]
    cos, sin = math.cos(math.radians(angle_deg)), math.sin(math.radians(angle_deg))
    spin = torch.tensor([[1.0, 0.0, 0.0], [0.0, cos, -sin], [0.0, sin, cos]], dtype=torch.float64)
    size = torch.tensor([0.0, 0.15, 0.1], dtype=torch.float64)
    true = frame @ spin
    points = (uniform(generator, 1, 2000, 3) * size) @ true.T
    plane = Plane(true[:, 0].expand(1, 3, 3), torch.zeros(1, 3, dtype=torch.float64))
    present = torch.ones(1, 2000, dtype=torch.bool)
    found = flat_frame(points, present, plane, torch.tensor([[False, True, True]]), 0.0)[0]
    assert float((found[:, 0] - true[:, 0]).abs().max()) < EXACT
    sides = (found.T @ true).abs()[1:, 1:].amax(dim=1)
    assert float(torch.rad2deg(torch.acos(sides.clamp(max=1.0))).max()) < 0.5
    assert float(torch.linalg.det(found)) == pytest.approx(1.0, abs=EXACT)


def test_the_first_flat_plane_is_the_one_that_counts(generator: torch.Generator) -> None:
    frame = random_turns(1, generator)[0]
    points = uniform(generator, 1, 100, 3)
    plane = Plane(frame.T[None], torch.zeros(1, 3, dtype=torch.float64))
    present = torch.ones(1, 100, dtype=torch.bool)
    for marks, chosen in (([False, False, True], 2), ([False, True, True], 1), ([True, False, True], 0)):
        found = flat_frame(points, present, plane, torch.tensor([marks]), 0.0)[0]
        assert torch.equal(found[:, 0], frame[:, chosen])
