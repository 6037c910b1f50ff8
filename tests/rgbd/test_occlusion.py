"""What was hidden from the camera."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest
import torch
from torch import Tensor

from blockstab.rgbd.frame import Camera
from blockstab.rgbd.occlusion import Occlusion

WIDTH, HEIGHT, FOCAL = 32, 24, 40.0
LEVEL = torch.diag(torch.tensor([1.0, -1.0, -1.0], dtype=torch.float64))  # +y up, looking along -z
SLACK = 0.02


def wall(depth_m: float = 1.0, world_from_camera: Tensor = LEVEL) -> Occlusion:
    """A wall straight ahead, with a hole without depth in its lower left corner."""
    depth = torch.full((HEIGHT, WIDTH), depth_m, dtype=torch.float64)
    depth[-4:, :4] = 0.0
    camera = Camera(FOCAL, FOCAL, (WIDTH - 1) / 2, (HEIGHT - 1) / 2)
    return Occlusion(depth, camera, world_from_camera)


def hidden(occlusion: Occlusion, *point: float) -> bool:
    return bool(occlusion.hidden(torch.tensor(point, dtype=torch.float64), SLACK))


@pytest.mark.parametrize(
    ("distance", "answer"), [(0.5, False), (1.0, False), (1.019, False), (1.021, True), (3.0, True)]
)
def test_a_point_is_hidden_if_it_lies_behind_the_surface_by_more_than_the_slack(
    distance: float, answer: bool
) -> None:
    assert hidden(wall(), 0.0, 0.0, -distance) is answer
    assert hidden(wall(), 0.2 * distance, 0.1 * distance, -distance) is answer


def test_what_lies_outside_the_image_is_hidden_however_near() -> None:
    edge = WIDTH / 2 / FOCAL
    assert hidden(wall(), 0.5 * (edge - 0.02), 0.0, -0.5) is False
    assert hidden(wall(), 0.5 * (edge + 0.02), 0.0, -0.5) is True
    assert hidden(wall(), -0.5 * (edge + 0.02), 0.0, -0.5) is True
    assert hidden(wall(), 0.0, 0.5, -0.5) is True
    assert hidden(wall(), 0.0, -0.5, -0.5) is True


def test_what_lies_behind_the_camera_or_in_it_is_hidden() -> None:
    assert hidden(wall(), 0.0, 0.0, 1.0) is True
    assert hidden(wall(), 0.0, 0.0, 0.0) is True


def test_where_the_sensor_gave_no_depth_everything_is_hidden() -> None:
    left, down = -14.0 / FOCAL, -10.0 / FOCAL
    assert hidden(wall(), 0.5 * left, 0.5 * down, -0.5) is True
    assert hidden(wall(), -0.5 * left, 0.5 * down, -0.5) is False


def test_depth_is_measured_along_the_axis_of_the_camera_not_along_the_ray() -> None:
    x = 0.35 * 1.01
    assert math.hypot(x, 1.01) > 1.06
    assert hidden(wall(), x, 0.0, -1.01) is False


def test_a_turned_camera_looks_where_its_rotation_says() -> None:
    down = math.radians(35)
    cos, sin = math.cos(down), math.sin(down)
    turn = torch.tensor([[1.0, 0.0, 0.0], [0.0, -cos, -sin], [0.0, sin, -cos]], dtype=torch.float64)
    occlusion = wall(world_from_camera=turn)
    ahead = turn @ torch.tensor([0.0, 0.0, 1.0], dtype=torch.float64)
    assert float(ahead[:2].sum()) < 0
    assert hidden(occlusion, *(0.9 * ahead).tolist()) is False
    assert hidden(occlusion, *(1.1 * ahead).tolist()) is True
    assert hidden(occlusion, 0.0, 0.0, -0.9) is True  # level: above the image


def test_each_pixel_answers_for_its_own_points() -> None:
    occlusion = wall()
    depth = occlusion.depth.clone()
    depth[5, 20] = 0.4
    occlusion = Occlusion(depth, occlusion.camera, occlusion.world_from_camera)
    v, u = torch.meshgrid(torch.arange(HEIGHT).double(), torch.arange(WIDTH).double(), indexing="ij")
    ray = torch.stack([(u - 15.5) / FOCAL, (v - 11.5) / FOCAL, torch.ones_like(u)], dim=-1)
    found = occlusion.hidden(0.5 * ray @ LEVEL.T, SLACK)
    expected = depth == 0
    expected[5, 20] = True
    assert torch.equal(found, expected)


def test_points_of_any_shape_get_an_answer_each() -> None:
    points = torch.zeros(3, 4, 5, 3, dtype=torch.float64)
    points[..., 2] = -0.5
    assert wall().hidden(points, SLACK).shape == (3, 4, 5)
    assert not bool(wall().hidden(points, SLACK).any())


def test_a_gap_is_as_far_as_what_lies_further_back_beside_it() -> None:
    depth = torch.tensor(
        [[1.0, 0.0, 0.0, 2.0, 0.0], [0.0, 3.0, 0.0, 1.0, 1.5], [0.0] * 5], dtype=torch.float64
    )
    filled = replace(wall(), depth=depth).without_gaps()
    expected = [[1.0, 2.0, 2.0, 2.0, 2.0], [3.0, 3.0, 3.0, 1.0, 1.5], [0.0] * 5]
    assert filled.depth.tolist() == expected
