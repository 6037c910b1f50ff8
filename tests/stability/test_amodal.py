"""Boxes whose lower part is hidden go down to what lies beneath; the others stay as they are."""

from __future__ import annotations

from collections.abc import Callable

import pytest
import torch
from torch import Tensor

from blockstab.boxes.box import Boxes
from blockstab.rgbd.frame import Camera
from blockstab.rgbd.occlusion import Occlusion
from blockstab.stability.amodal import HIDDEN_SHARE, extended_down
from blockstab.testing.worlds import Block, build
from tests.tolerance import EXACT

GROUND_Y = -0.6  # the camera is in the origin and looks along -z
BOARD_Z = -0.5

FLOATING = Block(0, 0.3, 0.2, 0.2, d=0.2)  # 30 cm above the ground


def placed(*blocks: Block, turn_deg: float = 30.0) -> Boxes:
    """The blocks 1.2 m before the camera, turned about the vertical so that it sees two of their sides."""
    boxes, _ = build(*blocks)
    angle = torch.deg2rad(torch.tensor(turn_deg, dtype=torch.float64))
    cos, sin, zero = torch.cos(angle), torch.sin(angle), torch.zeros((), dtype=torch.float64)
    turn = torch.stack([cos, zero, sin, zero, zero + 1, zero, -sin, zero, cos]).view(3, 3)
    turned = boxes.rotated(turn)
    place = torch.tensor([0.0, GROUND_Y, -1.2], dtype=torch.float64)
    return Boxes(turned.center + place, turned.rotation, turned.half_extent)


def behind_a_board(top_y: float) -> Callable[[Tensor], Tensor]:
    """Hidden is what lies below the line of sight over the top of a board half a metre before the camera."""
    return lambda points: points[..., 1] / -points[..., 2] < top_y / -BOARD_Z


NOWHERE = behind_a_board(-9.0)
EVERYWHERE = behind_a_board(9.0)


def lowered(boxes: Boxes, hidden: Callable[[Tensor], Tensor], floating: list[bool] | None = None) -> Boxes:
    """Let the first box float, or those that are named; any two may stand on each other."""
    n = len(boxes)
    marks = torch.tensor(floating or [k == 0 for k in range(n)])
    first, second = torch.triu_indices(n, n, 1)
    ground = torch.full((n,), GROUND_Y, dtype=torch.float64)
    return extended_down(boxes, marks, (first, second), ground, hidden)


def bottom(boxes: Boxes) -> list[float]:
    return boxes.corners()[..., 1].amin(dim=1).tolist()


def top(boxes: Boxes) -> list[float]:
    return boxes.corners()[..., 1].amax(dim=1).tolist()


def unchanged(before: Boxes, after: Boxes) -> bool:
    pairs = zip(
        (before.center, before.rotation, before.half_extent),
        (after.center, after.rotation, after.half_extent),
        strict=True,
    )
    return all(torch.equal(a, b) for a, b in pairs)


def test_a_box_that_floats_behind_something_goes_down_to_the_ground() -> None:
    boxes = placed(FLOATING)
    line = -0.3 / 1.0 * -BOARD_Z  # just above its lower edge as seen by the camera
    longer = lowered(boxes, behind_a_board(line))
    assert bottom(longer) == pytest.approx([GROUND_Y], abs=EXACT)
    assert top(longer) == pytest.approx(top(boxes), abs=EXACT)
    assert torch.equal(longer.rotation, boxes.rotation)
    assert torch.equal(longer.half_extent[:, [0, 2]], boxes.half_extent[:, [0, 2]])
    assert float((longer.center - boxes.center)[:, [0, 2]].abs().max()) < EXACT


def test_a_box_that_floats_in_plain_sight_stays() -> None:
    boxes = placed(FLOATING)
    assert unchanged(boxes, lowered(boxes, NOWHERE))


def test_a_box_of_whose_lower_part_too_much_is_in_sight_stays() -> None:
    boxes = placed(FLOATING)
    # What hangs in the air would be seen from y = -0.3 to y = -0.6 at about a metre.
    for part, moves in ((HIDDEN_SHARE + 0.1, True), (HIDDEN_SHARE - 0.1, False)):
        seen = (0.3 + 0.3 * (1 - part)) / 1.05
        assert unchanged(boxes, lowered(boxes, behind_a_board(seen * BOARD_Z))) is not moves


def test_a_box_over_another_goes_down_to_its_top() -> None:
    boxes = placed(FLOATING, Block(0, 0, 0.3, 0.15, d=0.3))
    longer = lowered(boxes, EVERYWHERE)
    assert bottom(longer)[0] == pytest.approx(GROUND_Y + 0.15, abs=EXACT)
    assert unchanged(boxes[1:], longer[1:])


def test_of_several_things_beneath_the_highest_stops_it_whatever_their_order() -> None:
    low, high = Block(-0.05, 0, 0.1, 0.05), Block(0.05, 0, 0.1, 0.2)
    for blocks in ((FLOATING, low, high), (FLOATING, high, low)):
        assert bottom(lowered(placed(*blocks), EVERYWHERE))[0] == pytest.approx(GROUND_Y + 0.2, abs=EXACT)
    last = placed(high, low, FLOATING)
    assert bottom(lowered(last, EVERYWHERE, [False, False, True]))[2] == pytest.approx(
        GROUND_Y + 0.2, abs=EXACT
    )


def test_what_is_under_less_than_a_tenth_of_a_box_does_not_stop_it() -> None:
    for overlap, floor in ((0.015, GROUND_Y), (0.025, GROUND_Y + 0.15)):
        beside = Block(0.2 - overlap, 0, 0.2, 0.15, d=0.2)
        longer = lowered(placed(FLOATING, beside), EVERYWHERE)
        assert bottom(longer)[0] == pytest.approx(floor, abs=EXACT)


def test_a_taller_neighbour_does_not_stop_a_box() -> None:
    boxes = placed(FLOATING, Block(0.1, 0, 0.1, 0.4, d=0.2))
    assert bottom(lowered(boxes, EVERYWHERE))[0] == pytest.approx(GROUND_Y, abs=EXACT)


def test_a_box_that_does_not_float_stays_to_the_bit() -> None:
    boxes = placed(FLOATING, Block(0.4, 0.1, 0.2, 0.2, d=0.2))
    longer = lowered(boxes, EVERYWHERE, [False, True])
    assert unchanged(boxes[:1], longer[:1])
    assert bottom(longer)[1] == pytest.approx(GROUND_Y, abs=EXACT)
    assert unchanged(boxes, lowered(boxes, EVERYWHERE, [False, False]))


@pytest.mark.parametrize(("tilt_deg", "moves"), [(5.0, True), (15.0, True), (25.0, False), (60.0, False)])
def test_only_a_box_that_stands_upright_is_lengthened(tilt_deg: float, moves: bool) -> None:
    boxes = placed(Block(0, 0.3, 0.2, 0.25, d=0.2, tilt_deg=tilt_deg))
    longer = lowered(boxes, EVERYWHERE)
    if not moves:
        assert unchanged(boxes, longer)
        return
    assert bottom(longer) == pytest.approx([GROUND_Y], abs=EXACT)
    assert top(longer) == pytest.approx(top(boxes), abs=EXACT)
    # It grows along its own axis: what it held, it still holds.
    grown = (longer.local(boxes.corners()).abs() <= longer.half_extent[:, None] + EXACT).all()
    assert bool(grown)


def test_a_box_that_lies_on_its_side_grows_along_the_axis_that_is_upright() -> None:
    boxes = placed(Block(0, 0.3, 0.2, 0.25, d=0.2, tilt_deg=92.0))
    longer = lowered(boxes, EVERYWHERE)
    assert bottom(longer) == pytest.approx([GROUND_Y], abs=EXACT)
    assert torch.equal(longer.half_extent[:, 1:], boxes.half_extent[:, 1:])


def test_a_box_that_reaches_below_the_ground_stays() -> None:
    boxes = placed(Block(0, -0.05, 0.2, 0.2, d=0.2))
    assert unchanged(boxes, lowered(boxes, EVERYWHERE))


def test_each_box_has_the_ground_of_its_own() -> None:
    boxes = placed(FLOATING, Block(0.5, 0.3, 0.2, 0.2, d=0.2))
    ground = torch.tensor([-0.6, -0.45], dtype=torch.float64)
    none = torch.zeros(0, dtype=torch.int64)
    longer = extended_down(boxes, torch.tensor([True, True]), (none, none), ground, EVERYWHERE)
    assert bottom(longer) == pytest.approx(ground.tolist(), abs=EXACT)


def test_only_sides_that_face_the_camera_are_asked_about() -> None:
    asked: list[Tensor] = []

    def front(points: Tensor) -> Tensor:
        # The far sides are "seen": they must not count, for no camera sees them.
        asked.append(points)
        return points[..., 2] > -1.2 + 1e-6

    boxes = placed(FLOATING, turn_deg=0.0)
    assert bottom(lowered(boxes, front)) == pytest.approx([GROUND_Y], abs=EXACT)
    asked_at = asked[0].flatten(0, -2)
    assert float(asked_at[:, 1].max()) < GROUND_Y + 0.3
    assert float(asked_at[:, 1].min()) > GROUND_Y


def test_a_depth_image_of_a_board_before_a_block_is_enough() -> None:
    height, width, focal = 120, 160, 100.0
    camera = Camera(focal, focal, (width - 1) / 2, (height - 1) / 2)
    v = torch.arange(height, dtype=torch.float64)[:, None].expand(-1, width)
    sight_y = -(v - camera.cy) / focal  # height above the middle, at one metre
    depth = torch.where(sight_y < -0.29, 0.5, 4.0).double()
    level = torch.diag(torch.tensor([1.0, -1.0, -1.0], dtype=torch.float64))
    boxes = placed(FLOATING)
    for seen, moves in ((depth, True), (torch.full_like(depth, 4.0), False)):
        occlusion = Occlusion(seen, camera, level)
        longer = lowered(boxes, lambda points, occlusion=occlusion: occlusion.hidden(points, 0.02))
        assert unchanged(boxes, longer) is not moves
