"""Points and normals of planes that are known exactly."""

from __future__ import annotations

import math

import pytest
import torch

from blockstab.rgbd.cloud import cloud_from_frame
from blockstab.rgbd.frame import Camera, Frame, read_scene
from tests.tolerance import EXACT

KINECT_STEP = 2.9e-3  # 1/m, the quantum of a Kinect's inverse depth
KINECT_NOISE = 1.5e-3  # 1/m
TILTED = (0.3, -0.8, -0.5)


def _angle_deg(first, second):
    cross = torch.linalg.cross(first, second.expand_as(first)).norm(dim=-1)
    return torch.rad2deg(torch.atan2(cross, (first * second).sum(dim=-1)))


def _frame(depth):
    height, width = depth.shape
    camera = Camera(262.5, 262.5, width / 2 - 0.5, height / 2 - 0.5)
    return Frame("test", torch.zeros(height, width, 3, dtype=torch.uint8), depth, camera)


def test_convention_camera_frame():
    """x right, y down, z forward; a pixel's coordinates are those of its centre."""
    depth = torch.zeros(40, 50, dtype=torch.float64)
    depth[30, 45] = 2.0
    camera = Camera(fx=500.0, fy=400.0, cx=20.0, cy=10.0)
    cloud = cloud_from_frame(Frame("one pixel", torch.zeros(40, 50, 3, dtype=torch.uint8), depth, camera))
    expected = [(45 - 20.0) * 2.0 / 500.0, (30 - 10.0) * 2.0 / 400.0, 2.0]
    assert cloud.points[30, 45].tolist() == pytest.approx(expected, abs=EXACT)
    assert cloud.points.dtype == torch.float64
    assert int(cloud.valid.sum()) == 1
    assert int(cloud.points.any(-1).sum()) == 1


@pytest.mark.parametrize("normal", [(0.0, 0.0, -1.0), (0.0, -1.0, -1.0), (0.5, 0.0, -1.0), TILTED])
def test_a_plane_has_its_exact_normal_towards_the_camera(look, normal):
    view = look({normal: 1.2})
    cloud = cloud_from_frame(view.frame)
    known = cloud.normals.any(-1)
    assert torch.equal(known, cloud.valid)
    assert _angle_deg(cloud.normals, view.normals)[known].max() < 1e-6
    assert ((cloud.normals * cloud.points).sum(-1)[known] < 0).all()


def test_a_plane_with_most_pixels_missing_keeps_its_exact_normal(look, generator):
    view = look({TILTED: 1.2})
    kept = torch.rand(view.frame.depth.shape, generator=generator) < 0.4
    cloud = cloud_from_frame(_frame(view.frame.depth * kept))
    known = cloud.normals.any(-1)
    assert not known[~kept].any()
    assert known[cloud.valid].double().mean() > 0.99
    assert _angle_deg(cloud.normals, view.normals)[known].max() < 1e-6


@pytest.mark.parametrize("normal", [(0.0, -1.0, -1.0), (0.17, 0.0, -1.0), TILTED])
def test_a_plane_at_a_metre_seen_by_a_kinect_has_its_normal_within_a_few_degrees(look, normal):
    view = look({normal: 0.7}, noise=KINECT_NOISE)
    quantised = KINECT_STEP * (1.0 / view.frame.depth / KINECT_STEP).round()
    depth = torch.where(view.frame.depth > 0, 1.0 / quantised, 0.0)
    cloud = cloud_from_frame(_frame(depth))
    error = _angle_deg(cloud.normals, view.normals)[cloud.normals.any(-1)]
    assert error.median() < 3.0
    assert error.quantile(0.95) < 6.0


def test_normals_turn_at_a_crease_within_two_pixels(look):
    """Two walls that meet at a right angle, with no jump in depth."""
    view = look({(0.7, 0.0, -0.7): 0.7, (-0.7, 0.0, -0.7): 0.7})
    error = _angle_deg(cloud_from_frame(view.frame).normals, view.normals)
    beside = (torch.arange(320) - 159.5).abs() > 2
    assert error[:, beside].max() < 5.0
    assert error[:, beside].median() < 1e-6


def test_normals_beside_a_jump_are_those_of_their_own_surface(look):
    """A board 20 cm in front of a tilted wall."""
    wall, board = look({TILTED: 1.0}), look({(0.0, 0.0, -1.0): 0.5})
    on_board = torch.zeros(240, 320, dtype=torch.bool)
    on_board[80:160, 100:200] = True
    cloud = cloud_from_frame(_frame(torch.where(on_board, board.frame.depth, wall.frame.depth)))
    truth = torch.where(on_board[..., None], board.normals, wall.normals)
    known = cloud.normals.any(-1)
    error = _angle_deg(cloud.normals, truth)[known]
    assert known[cloud.valid].double().mean() > 0.99
    assert (error < 1.0).double().mean() > 0.99


def test_a_lone_pixel_and_a_line_have_no_normal():
    depth = torch.zeros(40, 50, dtype=torch.float64)
    depth[10, 10] = 1.0
    depth[30, :] = 1.0
    cloud = cloud_from_frame(_frame(depth))
    assert not cloud.normals.any()


def test_an_image_smaller_than_a_window_is_no_error():
    cloud = cloud_from_frame(_frame(torch.ones(5, 6, dtype=torch.float64)))
    assert cloud.normals.flatten(0, 1).tolist() == [pytest.approx([0.0, 0.0, -1.0], abs=EXACT)] * 30


def test_rotating_a_cloud_turns_points_and_normals_but_not_depth(look):
    cloud = cloud_from_frame(look({TILTED: 1.2}).frame)
    turned = cloud.rotated(torch.tensor([[0.0, 1, 0], [-1, 0, 0], [0, 0, 1]], dtype=torch.float64))
    assert torch.equal(turned.points[..., 0], cloud.points[..., 1])
    assert torch.equal(turned.normals[..., 1], -cloud.normals[..., 0])
    assert torch.equal(turned.depth, cloud.depth)


def test_the_same_frame_gives_the_same_bytes(look):
    frame = look({TILTED: 1.2}, noise=KINECT_NOISE).frame
    assert torch.equal(cloud_from_frame(frame).normals, cloud_from_frame(frame).normals)


def test_the_table_of_a_real_scene_has_one_normal(real_scenes):
    frame = read_scene(real_scenes / "osd" / "learn30")
    cloud = cloud_from_frame(frame)
    table = (frame.label == 1) & cloud.normals.any(-1)
    error = _angle_deg(cloud.normals[table], frame.up_camera)
    assert table.sum() > 0.99 * (frame.label == 1).sum()
    assert error.median() < 5.0
    assert math.isclose(float(cloud.normals[table].norm(dim=-1).max()), 1.0, abs_tol=EXACT)
