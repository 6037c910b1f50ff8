"""Up and the ground of rooms that are known exactly, and of real tables."""

from __future__ import annotations

import math

import pytest
import torch

from blockstab.rgbd.cloud import Cloud, cloud_from_frame
from blockstab.rgbd.frame import read_scene
from blockstab.rgbd.ground import estimate_ground, ground_from_up, world_from_camera
from tests.tolerance import EXACT

NOISE = 1.5e-3  # 1/m of inverse depth: 1.5e-3 z^2 metres
FLOOR = {(0.0, -1.0, 0.0): 1.4}
CEILING = {(0.0, 1.0, 0.0): 1.2}
WALLS = {(0.82, 0.0, -0.57): 3.0, (-0.57, 0.0, -0.82): 3.0}
CORNER = FLOOR | WALLS


def _angle_deg(first, second):
    cross = torch.linalg.cross(first, second)
    return math.degrees(math.atan2(float(cross.norm()), float(first @ second)))


def _ups():
    directions = torch.randn(200, 3, generator=torch.Generator().manual_seed(3), dtype=torch.float64)
    axes = torch.cat([torch.eye(3), -torch.eye(3)]).double()
    nearly = axes + 1e-9 * directions[:6]
    ups = torch.cat([axes, nearly, directions])
    return ups / ups.norm(dim=1, keepdim=True)


def test_convention_world_frame():
    """+y up, right-handed, the origin at the camera; a level camera looks along -z with x to its right."""
    level = world_from_camera(torch.tensor([0.0, -1.0, 0.0], dtype=torch.float64))
    assert torch.equal(level, torch.diag(torch.tensor([1.0, -1.0, -1.0], dtype=torch.float64)))


def test_any_up_is_taken_to_y_by_a_rotation():
    for up in _ups():
        rotation = world_from_camera(up)
        assert (rotation @ up - torch.tensor([0.0, 1.0, 0.0])).abs().max() < EXACT
        assert (rotation @ rotation.T - torch.eye(3)).abs().max() < EXACT
        assert float(torch.linalg.det(rotation)) == pytest.approx(1.0, abs=EXACT)


@pytest.mark.parametrize("down_deg", [-60, -30, 0, 30, 60, 85])
@pytest.mark.parametrize("roll_deg", [0, 30, 90, -90])
def test_the_camera_looks_forward_in_the_world_unless_it_looks_along_up(look, down_deg, roll_deg):
    rotation = world_from_camera(look(FLOOR, down_deg, roll_deg).up)
    forward = rotation[:, 2]
    assert forward[2] < 0
    assert float(forward[1]) == pytest.approx(-math.sin(math.radians(down_deg)), abs=EXACT)


@pytest.mark.parametrize(("down_deg", "roll_deg"), [(d, 0) for d in range(0, 45, 5)] + [(0, 35), (30, 20)])
def test_up_in_a_room_corner_is_found_within_a_degree(look, down_deg, roll_deg):
    view = look(CORNER, down_deg, roll_deg, noise=NOISE)
    ground = estimate_ground(cloud_from_frame(view.frame))
    assert _angle_deg(ground.up_camera, view.up) < 0.3
    assert float(torch.linalg.det(ground.world_from_camera)) == pytest.approx(1.0, abs=EXACT)
    assert ground.confidence > 0.6


@pytest.mark.parametrize("down_deg", [20, 30, 40])
def test_the_floor_is_found_within_two_millimetres(look, down_deg):
    view = look(CORNER, down_deg, noise=NOISE)
    cloud = cloud_from_frame(view.frame)
    assert estimate_ground(cloud).height == pytest.approx(-1.4, abs=2e-3)
    assert ground_from_up(cloud, view.up).height == pytest.approx(-1.4, abs=2e-3)


def test_the_ground_plane_of_the_world_holds_the_floor(look):
    view = look(FLOOR, 30)
    cloud = cloud_from_frame(view.frame)
    ground = estimate_ground(cloud)
    world = cloud.rotated(ground.world_from_camera)
    assert world.points[..., 1][cloud.valid].tolist() == pytest.approx(
        [ground.height] * int(cloud.valid.sum()), abs=1e-6
    )


def test_the_ground_is_the_table_and_not_what_stands_on_it(look):
    """A table 0.6 m below the camera, and on half of it a level 8 cm higher."""
    table, raised = look({(0.0, -1.0, 0.0): 0.6}, 40, noise=NOISE), look({(0.0, -1.0, 0.0): 0.52}, 40)
    depth = table.frame.depth.clone()
    depth[:, 160:] = raised.frame.depth[:, 160:]
    ground = estimate_ground(cloud_from_frame(_with_depth(table.frame, depth)))
    assert ground.height == pytest.approx(-0.6, abs=2e-3)


def test_a_sliver_below_the_table_is_not_the_ground(look):
    """A table that fills the picture but for 3 % of it, where a chair is seen 30 cm lower."""
    table, chair = look({(0.0, -1.0, 0.0): 0.6}, 40), look({(0.0, -1.0, 0.0): 0.9}, 40)
    depth = table.frame.depth.clone()
    depth[:, :9] = chair.frame.depth[:, :9]
    ground = estimate_ground(cloud_from_frame(_with_depth(table.frame, depth)))
    assert ground.height == pytest.approx(-0.6, abs=2e-3)


def test_a_wall_alone_shows_no_ground(look):
    ground = estimate_ground(cloud_from_frame(look({(0.0, 0.0, -1.0): 2.0}, noise=NOISE).frame))
    assert ground.height is None
    assert ground.confidence < 0.1


def test_two_walls_show_up_but_no_ground(look):
    view = look(WALLS, noise=NOISE)
    ground = estimate_ground(cloud_from_frame(view.frame))
    assert _angle_deg(ground.up_camera, view.up) < 1.0
    assert ground.height is None
    assert ground.confidence < 0.1


def test_a_ceiling_is_no_ground(look):
    view = look(CEILING, -30, noise=NOISE)
    ground = estimate_ground(cloud_from_frame(view.frame))
    assert _angle_deg(ground.up_camera, view.up) < 1.0
    assert ground.height is None
    assert ground.confidence < 0.1


@pytest.mark.parametrize("down_deg", [50, 60, 70])
def test_a_table_seen_steeply_is_found_with_little_confidence(look, down_deg):
    view = look(FLOOR, down_deg, noise=NOISE)
    ground = estimate_ground(cloud_from_frame(view.frame))
    assert _angle_deg(ground.up_camera, view.up) < 1.0
    assert 0.1 < ground.confidence < 0.3


def test_random_normals_earn_no_confidence(generator):
    normals = torch.randn(100, 100, 3, generator=generator, dtype=torch.float64)
    normals = normals / normals.norm(dim=-1, keepdim=True)
    points = torch.rand(100, 100, 3, generator=generator, dtype=torch.float64) + 1.0
    cloud = Cloud(points, normals, torch.ones(100, 100, dtype=torch.bool), points[..., 2])
    assert estimate_ground(cloud).confidence < 0.1


def test_an_empty_cloud_is_taken_for_a_level_view_without_confidence():
    empty = torch.zeros(40, 50, 3, dtype=torch.float64)
    ground = estimate_ground(Cloud(empty, empty, empty[..., 0] > 0, empty[..., 0]))
    assert (ground.up_camera.tolist(), ground.height, ground.confidence) == ([0.0, -1.0, 0.0], None, 0.0)


def test_the_same_cloud_gives_the_same_bytes(look):
    cloud = cloud_from_frame(look(CORNER, 25, 5, noise=NOISE).frame)
    first, second = estimate_ground(cloud), estimate_ground(cloud)
    assert torch.equal(first.up_camera, second.up_camera)
    assert (first.height, first.confidence) == (second.height, second.confidence)


def test_a_known_up_is_kept_whatever_its_length(look):
    view = look(CORNER, 30)
    ground = ground_from_up(cloud_from_frame(view.frame), 7.0 * view.up)
    assert ground.up_camera.tolist() == pytest.approx(view.up.tolist(), abs=EXACT)
    assert ground.confidence == 1.0


@pytest.mark.parametrize("up", [[0.0, 0.0, 0.0], [0.0, math.nan, 1.0], [0.0, 1.0]])
def test_a_known_up_that_is_no_direction_is_refused(look, up):
    with pytest.raises(ValueError, match="up_camera must be three finite numbers that are not all zero, but"):
        ground_from_up(cloud_from_frame(look(FLOOR).frame), torch.tensor(up))


def test_up_and_table_of_real_scenes_are_found(real_scenes):
    """The true up of these scenes was fitted to their labelled table."""
    errors, heights = [], []
    for meta in sorted(real_scenes.glob("osd/*/meta.json"))[::3]:
        frame = read_scene(meta.parent)
        cloud = cloud_from_frame(frame)
        ground = estimate_ground(cloud)
        errors.append(_angle_deg(ground.up_camera, frame.up_camera))
        table = (cloud.points @ ground.up_camera)[(frame.label == 1) & cloud.valid]
        heights.append(abs(ground.height - float(table.median())))
    assert len(errors) == 17
    assert sorted(errors)[8] < 0.2
    assert max(errors) < 0.5
    assert max(heights) < 2e-3


@pytest.mark.parametrize("name", ["ycbv/ycbv01", "ycbv/ycbv02", "apc/frame00", "apc/frame07"])
def test_up_of_real_scenes_without_truth_is_plausible(real_scenes, name):
    """All were taken by a camera held upright that looks level or down, by less than 45 degrees."""
    up = estimate_ground(cloud_from_frame(read_scene(real_scenes / name))).up_camera
    assert up[1] < -0.7
    assert abs(up[0]) < 0.1
    assert up[2] < 0.05


def _with_depth(frame, depth):
    return type(frame)(frame.name, frame.color, depth, frame.camera)
