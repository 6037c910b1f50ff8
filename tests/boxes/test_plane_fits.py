"""Planes among noisy points: votes, degenerate samples, perpendicular planes, refinement."""

from __future__ import annotations

import math

import pytest
import torch
from torch import Tensor

from blockstab.boxes.plane_fits import first_plane, fixed_plane, perpendicular_plane, plane_basis, refine
from tests.seen_boxes import boxes_showing, random_turns, seen_points
from tests.tolerance import EXACT

RESTARTS, SAMPLES = 5, 10


def draws(generator: torch.Generator, sets: int, numbers: int) -> Tensor:
    return torch.rand(sets, RESTARTS, SAMPLES, numbers, generator=generator, dtype=torch.float64)


def everything(points: Tensor, tolerance_m: float = 0.01) -> tuple[Tensor, Tensor, Tensor]:
    """All points present, their number, and one tolerance for all."""
    present = torch.ones(points.shape[:2], dtype=torch.bool)
    return present, present.sum(dim=1), torch.full(points.shape[:2], tolerance_m, dtype=torch.float64)


def angle_deg(a: Tensor, b: Tensor) -> Tensor:
    """Between lines along unit vectors (..., 3)."""
    return torch.rad2deg(torch.asin(torch.linalg.cross(a, b).norm(dim=-1).clamp(max=1.0)))


@pytest.fixture
def turn(generator: torch.Generator) -> Tensor:
    return random_turns(1, generator)[0]


def plate(generator: torch.Generator, turn: Tensor, amount: int = 200, height: float = 0.0) -> Tensor:
    """Points of a plane square to the third column of `turn`."""
    flat = torch.rand(1, amount, 3, generator=generator, dtype=torch.float64) - 0.5
    flat[..., 2] = height
    return flat @ turn.T


def test_the_plane_of_most_points_is_found_among_strays(generator: torch.Generator, turn: Tensor) -> None:
    strays = torch.randn(1, 80, 3, generator=generator, dtype=torch.float64)
    points = torch.cat([plate(generator, turn, height=0.3), strays], dim=1)
    present, count, tolerance = everything(points, 0.002)
    plane = first_plane(points, present, count, tolerance, draws(generator, 1, 3))
    assert float(angle_deg(plane.normal, turn[:, 2].expand(1, RESTARTS, 3)).median()) < 0.2
    assert float((plane.offset.abs() - 0.3).abs().median()) < 0.001


def test_of_two_planes_the_one_with_more_points_wins(generator: torch.Generator, turn: Tensor) -> None:
    many, few = plate(generator, turn, 150), plate(generator, turn[:, [1, 2, 0]], 50)
    points = torch.cat([few, many], dim=1)
    present, count, tolerance = everything(points, 0.001)
    normal = first_plane(points, present, count, tolerance, draws(generator, 1, 3)).normal
    assert float(angle_deg(normal, turn[:, 2].expand(1, RESTARTS, 3)).max()) < 0.5


def test_a_sample_of_equal_points_wins_no_vote(generator: torch.Generator, turn: Tensor) -> None:
    # Every other point is the same: half of all samples span nothing, and a zero normal is near everything.
    points = plate(generator, turn)
    points[:, ::2] = points[:, :1].clone()
    noise = 0.002 * torch.randn(points.shape, generator=generator, dtype=torch.float64)
    noise[:, ::2] = 0.0
    points = points + noise
    present, count, tolerance = everything(points)
    plane = first_plane(points, present, count, tolerance, draws(generator, 1, 3))
    assert float(angle_deg(plane.normal, turn[:, 2].expand(1, RESTARTS, 3)).max()) < 1.0


def test_where_no_sample_spans_a_plane_all_points_are_used(generator: torch.Generator, turn: Tensor) -> None:
    points = plate(generator, turn)
    present, count, tolerance = everything(points)
    same = torch.full((1, RESTARTS, SAMPLES, 3), 0.3, dtype=torch.float64)
    plane = first_plane(points, present, count, tolerance, same)
    assert float(angle_deg(plane.normal, turn[:, 2].expand(1, RESTARTS, 3)).max()) < 1e-6


def test_absent_points_are_neither_drawn_nor_counted(generator: torch.Generator, turn: Tensor) -> None:
    points = torch.cat([plate(generator, turn, 60), plate(generator, turn[:, [1, 2, 0]], 140)], dim=1)
    present = torch.arange(200)[None] < 60
    tolerance = torch.full((1, 200), 0.001, dtype=torch.float64)
    plane = first_plane(points, present, torch.tensor([60]), tolerance, draws(generator, 1, 3))
    assert float(angle_deg(plane.normal, turn[:, 2].expand(1, RESTARTS, 3)).max()) < 1e-6


def test_a_fixed_plane_keeps_its_normal_and_goes_where_most_points_are(
    generator: torch.Generator, turn: Tensor
) -> None:
    points = torch.cat([plate(generator, turn, 150, 0.25), plate(generator, turn, 60, -0.1)], dim=1)
    present, count, tolerance = everything(points)
    axis = turn[:, 2][None]
    plane = fixed_plane(points, present, count, tolerance, draws(generator, 1, 1)[..., 0], axis)
    assert torch.equal(plane.normal, axis[:, None].expand(-1, RESTARTS, -1))
    assert float((plane.offset - 0.25).abs().max()) < EXACT


def test_the_second_plane_is_square_to_the_first_whatever_the_points(generator: torch.Generator) -> None:
    points = torch.randn(8, 100, 3, generator=generator, dtype=torch.float64)
    present, count, tolerance = everything(points, 0.2)
    plane = first_plane(points, present, count, tolerance, draws(generator, 8, 3))
    normal, _ = perpendicular_plane(points, present, tolerance, plane, draws(generator, 8, 2))
    assert float((normal * plane.normal).sum(dim=-1).abs().max()) < EXACT
    assert float((normal.norm(dim=-1) - 1).abs().max()) < EXACT


@pytest.mark.parametrize("angle", [0.0, 20.0, 45.0, 89.0, 90.0, 135.0, 170.0])
def test_the_second_plane_is_found_at_any_angle_about_the_first(
    angle: float, generator: torch.Generator
) -> None:
    cos, sin = math.cos(math.radians(angle)), math.sin(math.radians(angle))
    turn = torch.tensor([[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]], dtype=torch.float64)
    floor, wall = plate(generator, turn, 120), plate(generator, turn[:, [1, 2, 0]], 60, height=0.5)
    points = torch.cat([floor, wall], dim=1)
    present, count, tolerance = everything(points, 0.001)
    up = torch.tensor([[0.0, 0.0, 1.0]], dtype=torch.float64)
    plane = fixed_plane(points, present, count, tolerance, draws(generator, 1, 1)[..., 0], up)
    normal, flat = perpendicular_plane(points, present, tolerance, plane, draws(generator, 1, 2))
    assert not bool(flat.any())
    assert float(angle_deg(normal, turn[:, 0].expand(1, RESTARTS, 3)).max()) < 1e-6


@pytest.mark.parametrize(("left_over", "flat"), [(5, True), (40, False)])
def test_a_plane_needs_a_twentieth_of_the_points(
    left_over: int, flat: bool, generator: torch.Generator, turn: Tensor
) -> None:
    above = plate(generator, turn, left_over, height=0.4)
    points = torch.cat([plate(generator, turn, 400), above], dim=1)
    present, count, tolerance = everything(points)
    plane = first_plane(points, present, count, tolerance, draws(generator, 1, 3))
    _, found = perpendicular_plane(points, present, tolerance, plane, draws(generator, 1, 2))
    assert found.tolist() == [[flat] * RESTARTS]


def test_refinement_turns_a_rough_guess_into_the_axes_of_the_points(generator: torch.Generator) -> None:
    boxes = boxes_showing(3, 20, generator)
    points = seen_points(boxes, 1000, generator)
    rough = turned(boxes.rotation, 2.0, generator)
    present, _, tolerance = everything(points - boxes.center[:, None])
    refined = refine(rough, points - boxes.center[:, None], present, tolerance, None)
    before = angle_deg(rough.transpose(1, 2), boxes.rotation.transpose(1, 2)).amax(dim=1)
    after = angle_deg(refined.transpose(1, 2), boxes.rotation.transpose(1, 2)).amax(dim=1)
    assert float(before.min()) > 1.0
    assert float(after.max()) < 0.1


def turned(rotation: Tensor, degrees: float, generator: torch.Generator) -> Tensor:
    """Each turned by so much about an axis of its own."""
    axis = torch.nn.functional.normalize(
        torch.randn(len(rotation), 3, generator=generator, dtype=torch.float64), dim=1
    )
    units = torch.eye(3, dtype=torch.float64).expand(len(rotation), 3, 3)
    skew = torch.linalg.cross(axis[:, None].expand(-1, 3, -1), units, dim=-1).transpose(1, 2)
    return torch.linalg.matrix_exp(math.radians(degrees) * skew) @ rotation


def test_refinement_with_an_axis_turns_about_that_axis_only(generator: torch.Generator) -> None:
    boxes = boxes_showing(3, 20, generator)
    points = seen_points(boxes, 1000, generator) - boxes.center[:, None]
    rough = turned(boxes.rotation, 2.0, generator)
    present, _, tolerance = everything(points)
    refined = refine(rough, points, present, tolerance, rough[..., 1])
    assert float((refined[..., 1] - rough[..., 1]).abs().max()) < EXACT
    assert float((refined - rough).abs().max()) > 1e-3


def test_refinement_leaves_what_one_face_does_not_determine(generator: torch.Generator) -> None:
    turn = random_turns(1, generator)
    disc = torch.randn(1, 500, 3, generator=generator, dtype=torch.float64)
    disc = 0.1 * torch.nn.functional.normalize(disc * torch.tensor([1.0, 1.0, 0.0]), dim=-1)
    radius = torch.rand(1, 500, 1, generator=generator, dtype=torch.float64).sqrt()
    points = (disc * radius) @ turn.transpose(1, 2)
    present, _, tolerance = everything(points, 0.001)
    refined = refine(turn, points, present, tolerance, None)
    assert float((refined - turn).abs().max()) < 1e-6


def test_a_plane_basis_is_right_handed_and_of_unit_length(generator: torch.Generator) -> None:
    axes = torch.cat([torch.eye(3), -torch.eye(3)]).double()
    random = torch.nn.functional.normalize(
        torch.randn(50, 3, generator=generator, dtype=torch.float64), dim=1
    )
    normal = torch.cat([axes, random])
    u, v = plane_basis(normal)
    basis = torch.stack([u, v, normal], dim=-1)
    identity = torch.eye(3, dtype=torch.float64)
    assert float((basis.transpose(1, 2) @ basis - identity).abs().max()) < EXACT
    assert float((torch.linalg.det(basis) - 1).abs().max()) < EXACT
