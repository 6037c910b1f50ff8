"""Boxes of minimum surface distance recover what was seen: axes, extents, what a given axis changes."""

from __future__ import annotations

import math

import pytest
import torch

from blockstab.boxes.box import Boxes, checked
from blockstab.boxes.fitting import PAPER_TOLERANCE, MinimumSurface, PlaneTolerance, judged
from tests.seen_boxes import (
    POINTS,
    axis_error_deg,
    boxes_showing,
    fitted,
    half_extent_error,
    on_faces,
    seen_points,
)
from tests.tolerance import EXACT

UP = torch.tensor([[0.0, 1.0, 0.0]], dtype=torch.float64)


@pytest.mark.parametrize("noise_m", [0.0015, 0.003])
@pytest.mark.parametrize("faces", [2, 3])
def test_two_faces_are_enough_for_axes_within_half_a_degree(
    faces: int, noise_m: float, generator: torch.Generator
) -> None:
    boxes = boxes_showing(faces, 60, generator)
    fits = fitted(seen_points(boxes, POINTS, generator, noise_m))
    error = axis_error_deg(fits.boxes, boxes)
    assert float(error.mean()) < 0.2
    assert float(error.max()) < 1.0
    assert float(half_extent_error(fits.boxes, boxes).abs().max()) < 0.005
    assert float(half_extent_error(fits.boxes, boxes).abs().mean()) < 0.0015


@pytest.mark.parametrize("noise_m", [0.0015, 0.003])
def test_one_face_is_enough_for_the_directions_of_its_sides(
    noise_m: float, generator: torch.Generator
) -> None:
    boxes = boxes_showing(1, 60, generator)
    fits = fitted(seen_points(boxes, POINTS, generator, noise_m))
    error = axis_error_deg(fits.boxes, boxes)
    assert float(error.mean()) < 0.7  # a trimmed rectangle tells small turns badly apart
    assert float(error.quantile(0.9)) < 1.5
    seen = half_extent_error(fits.boxes, boxes).abs().sort(dim=1).values[:, :2]
    assert float(seen.max()) < 0.005
    assert float(fits.boxes.half_extent.amin(dim=1).max()) < 0.015


def test_the_top_of_a_book_is_fitted_flat_with_its_own_sides(generator: torch.Generator) -> None:
    cos, sin = math.cos(0.4), math.sin(0.4)
    turn = torch.tensor([[cos, 0.0, sin], [0.0, 1.0, 0.0], [-sin, 0.0, cos]], dtype=torch.float64)
    books = Boxes(
        torch.tensor([[0.1, -0.5, -0.7]], dtype=torch.float64).expand(20, -1),
        turn.expand(20, -1, -1),
        torch.tensor([[0.08, 0.01, 0.12]], dtype=torch.float64).expand(20, -1),
    )
    place = 2 * torch.rand(20, POINTS, 3, generator=generator, dtype=torch.float64) - 1
    top = on_faces(books, torch.full((20, POINTS), 2), place)
    top = top * (1 + 0.001 * torch.randn(20, POINTS, 1, generator=generator, dtype=torch.float64))
    fits = fitted(top)
    assert (
        float(axis_error_deg(fits.boxes, books).mean()) < 2.0
    )  # a trimmed rectangle tells small turns badly apart
    assert float(axis_error_deg(fits.boxes, books).max()) < 4.5
    assert float(half_extent_error(fits.boxes, books)[:, [0, 2]].abs().max()) < 0.004
    assert float(fits.boxes.half_extent.amin(dim=1).max()) < 0.006
    up = (fits.boxes.rotation.transpose(1, 2) @ UP[0]).abs().amax(dim=1)
    assert float(up.min()) > math.cos(math.radians(0.5))


@pytest.mark.parametrize("faces", [2, 3])
def test_without_noise_the_box_is_exact(faces: int, generator: torch.Generator) -> None:
    boxes = boxes_showing(faces, 20, generator)
    corners = boxes.corners()
    onto = torch.cat([seen_points(boxes, POINTS - 600, generator), corners.repeat(1, 75, 1)], dim=1)
    fits = fitted(onto[:, torch.randperm(POINTS, generator=generator)])
    assert float(axis_error_deg(fits.boxes, boxes).max()) < 1e-4
    assert float(half_extent_error(fits.boxes, boxes).abs().max()) < 1e-6
    assert float((fits.boxes.center - boxes.center).norm(dim=1).max()) < 1e-6
    assert float(fits.mean.max()) < 1e-6


@pytest.mark.parametrize("faces", [1, 2, 3])
def test_a_given_axis_becomes_an_axis_of_the_box_exactly(faces: int, generator: torch.Generator) -> None:
    boxes = boxes_showing(faces, 30, generator)
    points = seen_points(boxes, POINTS, generator, 0.003)
    tilted = torch.randn(30, 3, generator=generator, dtype=torch.float64)
    near = torch.nn.functional.normalize(boxes.rotation[..., 0] + 0.03 * tilted, dim=1)
    for axis in (near, torch.nn.functional.normalize(tilted, dim=1)):
        found = fitted(points, axis=axis).boxes
        likeness = (found.rotation.transpose(1, 2) @ axis[..., None]).abs()[..., 0].amax(dim=1)
        assert float(likeness.min()) > 1 - EXACT
        checked(found)


def test_the_right_axis_brings_the_other_two_closer_to_the_truth(generator: torch.Generator) -> None:
    boxes = boxes_showing(2, 60, generator)
    points = seen_points(boxes, 300, generator, 0.006)
    free, follow = fitted(points), fitted(points, axis=boxes.rotation[..., 0])
    assert float(axis_error_deg(follow.boxes, boxes).mean()) < float(axis_error_deg(free.boxes, boxes).mean())


def test_the_box_of_least_surface_distance_is_chosen_among_the_restarts(generator: torch.Generator) -> None:
    boxes = boxes_showing(3, 40, generator)
    points = seen_points(boxes, 256, generator, 0.004)
    once = fitted(points, MinimumSurface(restarts=1, samples=1))
    often = fitted(points, MinimumSurface(restarts=15, samples=10))
    assert float(often.mean.mean()) < float(once.mean.mean())
    assert float(axis_error_deg(often.boxes, boxes).mean()) < float(axis_error_deg(once.boxes, boxes).mean())


def test_the_tolerance_grows_with_the_square_of_the_distance() -> None:
    points = torch.tensor([[0.0, 0.0, 0.0], [0.0, 0.6, 0.8], [0.0, 0.0, -2.0]], dtype=torch.float64)
    found = PlaneTolerance(floor_m=0.003, per_square_m=0.0035).at(points)
    assert found.tolist() == pytest.approx([0.003, 0.0065, 0.017], abs=EXACT)


def test_the_tolerance_of_the_paper_is_two_centimetres_everywhere() -> None:
    points = torch.tensor([[0.0, 0.0, 0.1], [0.0, 0.0, 5.0]], dtype=torch.float64)
    assert PAPER_TOLERANCE.at(points).tolist() == [0.02, 0.02]


def test_noise_that_grows_with_distance_is_met_better_by_a_tolerance_that_does(
    generator: torch.Generator,
) -> None:
    near = boxes_showing(3, 40, generator)
    small = Boxes(near.center, near.rotation, near.half_extent * 0.4)  # 2.4 to 12 cm: 2 cm blur their edges
    points = seen_points(small, POINTS, generator, 0.0015)
    paper = fitted(points, MinimumSurface(tolerance=PAPER_TOLERANCE))
    assert float(axis_error_deg(fitted(points).boxes, small).mean()) < float(
        axis_error_deg(paper.boxes, small).mean()
    )


def test_mean_and_variance_are_those_of_the_distance_to_the_nearest_face() -> None:
    cube = Boxes(
        torch.tensor([[0.0, 0.0, -1.0]], dtype=torch.float64),
        torch.eye(3, dtype=torch.float64)[None],
        torch.full((1, 3), 0.1, dtype=torch.float64),
    )
    # In the middle, on a face, 3 and 4 cm past an edge, and one that does not count.
    points = torch.tensor(
        [[[0.0, 0.0, -1.0], [0.1, 0.02, -1.0], [0.13, 0.14, -1.0], [9.0, 9.0, 9.0]]], dtype=torch.float64
    )
    fits = judged(cube, points, torch.tensor([[True, True, True, False]]))
    assert float(fits.mean[0]) == pytest.approx(0.05, abs=EXACT)
    assert float(fits.variance[0]) == pytest.approx((0.05**2 + 0.05**2 + 0.0) / 3, abs=EXACT)
