"""Which gaps are shadows, and what they lie on."""

from __future__ import annotations

import math

import pytest
import torch

from blockstab.rgbd.noise import KINECT
from blockstab.segments.shadows import cast_on, shadows

FOCAL_PX = 525.0


def wall_and_post(near: float, far: float, gap_px: int) -> torch.Tensor:
    """A post at columns 30 to 49 in front of a wall, with a gap to the left of it."""
    depth = torch.full((4, 80), far, dtype=torch.float64)
    depth[:, 30:50] = near
    depth[:, 30 - gap_px : 30] = 0.0
    return depth


def width_px(near: float, far: float) -> float:
    return FOCAL_PX * KINECT.baseline_m * (1 / near - 1 / far)


@pytest.mark.parametrize(("near", "far"), [(0.7, 1.0), (1.0, 1.3), (2.0, 3.0)])
def test_a_gap_as_wide_as_the_sensor_s_eyes_make_it_is_a_shadow_on_what_is_behind(
    near: float, far: float
) -> None:
    gap = math.floor(width_px(near, far))
    shadow = shadows(wall_and_post(near, far, gap), FOCAL_PX, KINECT.baseline_m)
    assert bool((shadow[:, 30 - gap : 30] == 30 - gap - 1).all())
    assert int((shadow >= 0).sum()) == 4 * gap


def test_a_wider_gap_is_a_thing_that_the_sensor_does_not_see() -> None:
    gap = math.ceil(width_px(0.8, 1.0)) + 5
    assert bool((shadows(wall_and_post(0.8, 1.0, gap), FOCAL_PX, KINECT.baseline_m) == -1).all())


def test_a_gap_between_equal_depths_is_no_shadow() -> None:
    assert bool((shadows(wall_and_post(1.0, 1.0, 4), FOCAL_PX, KINECT.baseline_m) == -1).all())


def test_shadows_may_fall_to_either_side() -> None:
    depth = wall_and_post(0.8, 1.0, 5).flip(1)
    assert bool((shadows(depth, FOCAL_PX, KINECT.baseline_m)[:, 50:55] == 55).all())


def test_a_gap_at_the_rim_of_the_image_or_an_empty_row_has_no_shadow() -> None:
    depth = torch.ones(3, 20, dtype=torch.float64)
    depth[:, :4], depth[:, 17:], depth[1] = 0.0, 0.0, 0.0
    assert bool((shadows(depth, FOCAL_PX, KINECT.baseline_m) == -1).all())


def test_labels_in_a_shadow_are_those_of_what_it_lies_on_and_others_stay() -> None:
    depth = wall_and_post(0.8, 1.0, 6)
    label = torch.where(depth == 0.8, 2, 1).long()
    label[:, 24:30] = 2  # the post has grown into its shadow
    moved = cast_on(label, shadows(depth, FOCAL_PX, KINECT.baseline_m))
    assert torch.equal(moved, torch.where(depth == 0.8, 2, 1))
