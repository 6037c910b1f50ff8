"""Which sign of depth answers to which surface, at which orientation."""

from __future__ import annotations

import math
from collections.abc import Iterator

import pytest
import torch
from torch import Tensor
from torch.nn.functional import max_pool2d

from blockstab.boundaries.relief import RELIEF, relief
from blockstab.rgbd.frame import Camera, Frame
from blockstab.rgbd.noise import KINECT
from tests.block_scene import APART, TABLE_Y, picture

SIZE, FOCAL, AWAY = 81, 525.0, 0.8  # pixels, pixels, metres
MIDDLE = SIZE // 2
STEP = KINECT.step * AWAY**2  # more than a crease between two pixels explains
DEPTH, CONVEX, CONCAVE = range(3)


def frame_of(depth: Tensor) -> Frame:
    color = torch.full((*depth.shape, 3), 120, dtype=torch.uint8)
    return Frame("made", color, depth, Camera(FOCAL, FOCAL, MIDDLE, MIDDLE))


def across(k: int) -> Tensor:
    """(SIZE, SIZE) pixels from the line through the middle with a tangent at 45 k degrees, with their sign."""
    angle = math.radians(45 * k)
    v, u = torch.meshgrid(torch.arange(SIZE) - MIDDLE, torch.arange(SIZE) - MIDDLE, indexing="ij")
    return (u * math.sin(angle) + v * math.cos(angle)).double()


def fold(k: int, half_deg: float, concave: bool) -> Frame:
    """Two planes that meet in that line, each turned by `half_deg` from facing the camera."""
    slope = math.tan(math.radians(half_deg)) * across(k) / FOCAL
    sides = torch.stack([AWAY / (1 + slope), AWAY / (1 - slope)])
    return frame_of(sides.amin(dim=0) if concave else sides.amax(dim=0))


def step(k: int, steps: float) -> Frame:
    """Two planes that face the camera, one nearer by so many steps of the sensor."""
    return frame_of(torch.where(across(k) >= 0, AWAY, AWAY + steps * STEP))


def slanted(tilt_deg: float, turn_deg: float = 30.0) -> Tensor:
    """Depth of one plane."""
    turn = math.radians(turn_deg)
    way = across(0) * math.cos(turn) + across(2) * math.sin(turn)
    return AWAY / (1 - math.tan(math.radians(tilt_deg)) * way / FOCAL)


@pytest.fixture
def threads() -> Iterator[None]:
    before = torch.get_num_threads()
    yield
    torch.set_num_threads(before)


@pytest.mark.parametrize("k", range(4))
@pytest.mark.parametrize("concave", [False, True], ids=["convex", "concave"])
def test_a_fold_answers_in_its_own_channel_and_orientation(k: int, concave: bool) -> None:
    found = relief(fold(k, 13.0, concave))[:, :, MIDDLE, MIDDLE]
    own, other = (CONCAVE, CONVEX) if concave else (CONVEX, CONCAVE)
    assert 0.3 < float(found[own, k]) < 1.0
    assert int(found[own].argmax()) == k
    assert float(found[own, (k + 2) % 4]) == 0.0
    assert float(found[other].max()) == 0.0
    assert float(found[DEPTH].max()) == 0.0


@pytest.mark.parametrize("concave", [False, True], ids=["convex", "concave"])
def test_a_right_angle_is_a_full_crease_along_its_line_and_none_away_from_it(concave: bool) -> None:
    found = relief(fold(2, 45.0, concave))[CONCAVE if concave else CONVEX].amax(dim=0)
    assert float(found[:, MIDDLE].min()) == 1.0
    assert float(found[:, across(2)[0].abs() > 9].max()) == 0.0


@pytest.mark.parametrize("k", range(4))
def test_a_step_of_two_sensor_steps_is_no_edge_and_one_of_ten_is(k: int) -> None:
    assert float(relief(step(k, 2.0))[DEPTH].max()) < 0.02
    found = relief(step(k, 10.0))[DEPTH]
    line, clear = across(k).abs() < 1.0, across(k).abs() > 4.0
    inner = torch.zeros(SIZE, SIZE, dtype=torch.bool)
    inner[10:-10, 10:-10] = True
    assert float(found[k][line & inner].min()) == 1.0
    assert float(found[(k + 2) % 4].max()) < 0.3
    assert float(found.amax(dim=0)[clear].max()) == 0.0


@pytest.mark.parametrize("steps", [10.0, 100.0])
def test_a_step_is_no_crease(steps: float) -> None:
    found = relief(step(2, steps))
    assert float(found[CONVEX].max()) == 0.0
    assert float(found[CONCAVE].max()) == 0.0


@pytest.mark.parametrize("tilt_deg", [0.0, 30.0, 60.0, 75.0])
def test_a_slanted_plane_gives_nothing(tilt_deg: float) -> None:
    assert float(relief(frame_of(slanted(tilt_deg))).max()) == 0.0


@pytest.mark.parametrize("tilt_deg", [0.0, 60.0])
def test_the_sensors_noise_and_lost_pixels_give_next_to_nothing(
    tilt_deg: float, generator: torch.Generator
) -> None:
    noise = KINECT.deviation * torch.randn(SIZE, SIZE, generator=generator, dtype=torch.float64)
    depth = 1 / (1 / slanted(tilt_deg) + noise)
    depth[torch.rand(SIZE, SIZE, generator=generator) < 0.1] = 0.0
    found = relief(frame_of(depth))
    assert float((found > 0.25).double().mean()) < 0.001


def test_a_shadow_shows_the_jump_across_it_but_not_a_hole_in_a_plane() -> None:
    for steps, edge in ((0.0, False), (20.0, True)):
        frame = step(2, steps)
        frame.depth[:, MIDDLE - 2 : MIDDLE + 2] = 0.0
        found = relief(frame)[DEPTH, 2, :, MIDDLE - 2 : MIDDLE + 2]
        assert float(found.amax(dim=1).min()) == float(edge)


def test_the_edges_of_a_block_are_what_they_are() -> None:
    scene = picture(APART)
    found = relief(scene.frame).amax(dim=1)
    label, height = scene.frame.label, scene.cloud.points[..., 1] - TABLE_Y
    block, top = label == 2, (label == 2) & (height > APART[0][1][1] - 1e-6)
    edge = beside(top, block & ~top)
    assert int(edge.sum()) > 20
    # At the corners a disc spans three faces.
    assert float((found[CONVEX][edge] > 0.8).double().mean()) > 0.85
    assert float(found[CONCAVE][edge].max()) < 0.2
    foot = beside(block & ~top & (height < 0.02), label == 1)
    assert int(foot.sum()) > 20
    assert float(near(found[CONCAVE])[foot].min()) > 0.6
    # Above the block's upper rim the table lies far behind.
    behind = torch.zeros_like(block)
    behind[1:] = top[1:] & (label[:-1] == 1)
    assert float(near(found[DEPTH])[behind].min()) == 1.0


def beside(mask: Tensor, other: Tensor) -> Tensor:
    """Pixels of the mask with the other one right above or below, three pixels or more from the mask's ends."""
    touching = torch.zeros_like(mask)
    touching[1:] |= mask[1:] & other[:-1]
    touching[:-1] |= mask[:-1] & other[1:]
    ends = max_pool2d((~(mask | other)).double()[None], (1, 13), stride=1, padding=(0, 6))[0] > 0
    return touching & ~ends


def near(image: Tensor) -> Tensor:
    return max_pool2d(image[None], 5, stride=1, padding=2)[0]


def test_an_image_without_depth_has_no_relief() -> None:
    found = relief(frame_of(torch.zeros(SIZE, SIZE, dtype=torch.float64)))
    assert found.shape == (len(RELIEF), 4, SIZE, SIZE)
    assert found.dtype == torch.float32
    assert not found.any()


def test_relief_does_not_depend_on_the_number_of_threads(threads: None) -> None:
    frame, found = picture(APART).frame, []
    for count in (1, 2):
        torch.set_num_threads(count)
        found.append(relief(frame))
    assert torch.equal(*found)
    assert bool(found[0].isfinite().all())
    assert 0.0 <= float(found[0].min()) <= float(found[0].max()) == 1.0
