"""Table, floor and walls are background; what stands on and before them is not."""

from __future__ import annotations

import math

import pytest
import torch
from torch import Tensor

from blockstab.boxes.background import BackgroundRules, is_background
from blockstab.boxes.box import MIN_HALF_EXTENT, Boxes
from tests.seen_boxes import seen_points

GROUND_Y = -0.6
SMALL = 0.05  # share of the image


def judged(
    center: tuple[float, float, float],
    size: tuple[float, float, float],
    tilt_deg: float = 0.0,
    share: float = SMALL,
    noise_m: float = 0.001,
) -> tuple[bool, bool]:
    """What is said of a box of this full size, tilted about the z axis, by what the camera sees of it."""
    generator = torch.Generator().manual_seed(5)
    boxes = thing(center, size, tilt_deg)
    return say(boxes, seen_points(boxes, 400, generator, noise_m), 400, share)


def say(boxes: Boxes, points: Tensor, count: int, share: float = SMALL) -> tuple[bool, bool]:
    background, level = is_background(
        boxes, points, torch.tensor([count]), torch.tensor([share]), GROUND_Y, BackgroundRules()
    )
    return bool(background[0]), bool(level[0])


def thing(
    center: tuple[float, float, float], size: tuple[float, float, float], tilt_deg: float = 0.0
) -> Boxes:
    cos, sin = math.cos(math.radians(tilt_deg)), math.sin(math.radians(tilt_deg))
    return Boxes(
        torch.tensor([center], dtype=torch.float64),
        torch.tensor([[[cos, -sin, 0], [sin, cos, 0], [0, 0, 1]]], dtype=torch.float64),
        (torch.tensor([size], dtype=torch.float64) / 2).clamp(min=MIN_HALF_EXTENT),
    )


def on_the_table(top_m: float, width: float = 0.2, **more: float) -> tuple[bool, bool]:
    """A flat thing whose top lies so high above the ground; only its top is seen."""
    top = GROUND_Y + top_m
    return judged((0.1, top - MIN_HALF_EXTENT, -0.8), (width, 0.0, width), **more)


@pytest.mark.parametrize("noise_m", [0.0, 0.003])
def test_the_table_is_background_and_lies_in_the_ground(noise_m: float) -> None:
    assert on_the_table(0.0, width=0.8, noise_m=noise_m) == (True, True)


def test_a_patch_of_the_table_between_things_is_background() -> None:
    assert on_the_table(0.002, width=0.06) == (True, True)


def test_a_book_of_fifteen_millimetres_on_the_table_is_an_object() -> None:
    assert on_the_table(0.015)[0] is False


@pytest.mark.parametrize("height", [0.05, 0.3])
def test_a_block_on_the_table_is_an_object_off_the_ground(height: float) -> None:
    block = judged((0.1, GROUND_Y + height / 2, -0.8), (0.15, height, 0.1))
    assert block == (False, False)


def test_a_shelf_board_is_an_object_although_it_is_level() -> None:
    assert on_the_table(0.25, width=0.4) == (False, False)


def test_a_wall_is_background() -> None:
    assert judged((0.0, 0.0, -1.5), (2.0, 1.2, 0.0)) == (True, False)


def test_a_board_as_upright_as_a_wall_but_smaller_is_an_object() -> None:
    assert judged((0.0, 0.0, -1.5), (1.2, 0.8, 0.0)) == (False, False)


def test_a_large_board_that_leans_is_an_object() -> None:
    assert judged((0.9, 0.0, -1.5), (0.0, 2.0, 1.0), tilt_deg=25.0) == (False, False)
    assert judged((0.9, 0.0, -1.5), (0.0, 2.0, 1.0), tilt_deg=5.0) == (True, False)


def test_a_plane_that_fills_much_of_the_image_is_background_however_it_lies() -> None:
    ramp = {"center": (0.9, 0.0, -1.5), "size": (0.0, 1.0, 1.0), "tilt_deg": 40.0}
    assert judged(**ramp, share=0.15)[0] is False
    assert judged(**ramp, share=0.25)[0] is True


def test_a_block_that_fills_much_of_the_image_is_an_object() -> None:
    assert judged((0.1, -0.3, -0.8), (0.4, 0.4, 0.4), share=0.5)[0] is False


@pytest.mark.parametrize(("tilt_deg", "background"), [(1.5, True), (8.0, False)])
def test_a_board_whose_points_rise_from_the_ground_is_no_ground(tilt_deg: float, background: bool) -> None:
    assert judged((0.0, GROUND_Y - 0.005, -0.8), (0.3, 0.0, 0.3), tilt_deg=tilt_deg)[0] is background


def test_the_floor_beyond_the_edge_of_the_table_is_background_but_not_the_ground() -> None:
    assert judged((0.0, -1.3, -2.0), (1.0, 0.0, 1.0)) == (True, False)


def test_whatever_lies_well_below_the_ground_is_background() -> None:
    assert judged((0.0, -1.2, -2.0), (0.3, 0.3, 0.3)) == (True, False)


def test_a_block_that_noise_sinks_a_little_into_the_table_is_an_object() -> None:
    assert judged((0.1, GROUND_Y, -0.8), (0.15, 0.04, 0.1))[0] is False


@pytest.mark.parametrize(("table_share", "background"), [(0.9, True), (0.7, False)])
def test_a_table_may_have_swallowed_a_fifth_of_other_things_and_no_more(
    table_share: float, background: bool, generator: torch.Generator
) -> None:
    table = thing((0.0, GROUND_Y - MIN_HALF_EXTENT, -0.8), (0.6, 0.0, 0.6))
    points = seen_points(table, 400, generator)
    points[:, int(400 * table_share) :, 1] += 0.1
    assert say(table, points, 400)[0] is background


def test_rows_past_the_count_do_not_count(generator: torch.Generator) -> None:
    table = thing((0.0, GROUND_Y - MIN_HALF_EXTENT, -0.8), (0.6, 0.0, 0.6))
    points = seen_points(table, 400, generator)
    points[:, 100:, 1] += 0.1
    assert say(table, points, 100) == (True, True)
    assert say(table, points, 400) == (False, False)


def test_segments_are_judged_each_by_itself(generator: torch.Generator) -> None:
    table = thing((0.0, GROUND_Y - MIN_HALF_EXTENT, -0.8), (0.6, 0.0, 0.6))
    block = thing((0.1, -0.5, -0.8), (0.2, 0.2, 0.2))
    both = Boxes(
        torch.cat([table.center, block.center]),
        torch.cat([table.rotation, block.rotation]),
        torch.cat([table.half_extent, block.half_extent]),
    )
    points = seen_points(both, 300, generator)
    background, level = is_background(
        both, points, torch.tensor([300, 300]), torch.tensor([0.1, 0.1]), GROUND_Y, BackgroundRules()
    )
    assert background.tolist() == [True, False]
    assert level.tolist() == [True, False]
