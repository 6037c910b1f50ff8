"""Where the camera stands."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import torch

from blockstab.boxes.box import Boxes
from blockstab.datasets.viewpoint import draw_view, furnish
from tests.tolerance import EXACT

Upright = Callable[[Sequence[tuple[float, ...]]], Boxes]
PILE = [(0.1, 0.05, 0.0, 0.05, 0.05, 0.05), (-0.1, 0.1, 0.2, 0.05, 0.1, 0.05)]


def test_the_camera_looks_down_on_the_middle_of_the_pile(
    upright: Upright, generator: torch.Generator
) -> None:
    pile = upright(PILE)
    for _ in range(20):
        view = draw_view(generator, pile)
        middle = view.in_camera(pile).center.mean(dim=0)
        assert torch.allclose(middle[:2], torch.zeros(2, dtype=torch.float64), atol=EXACT)
        assert 0.8 <= float(middle[2]) <= 1.4
        up = view.up_camera()
        assert 20 <= math.degrees(math.asin(-float(up[2]))) <= 50
        assert abs(math.degrees(math.atan2(float(up[0]), -float(up[1])))) < 6


def test_convention_camera_axes_are_right_handed_and_the_table_is_below(
    upright: Upright, generator: torch.Generator
) -> None:
    pile = upright(PILE)
    view = draw_view(generator, pile)
    rotation = view.camera_from_table
    assert torch.allclose(rotation @ rotation.T, torch.eye(3, dtype=torch.float64), atol=EXACT)
    assert float(torch.linalg.det(rotation)) > 0
    # A point higher above the table is higher up in the picture, where y is smaller.
    heights = view.in_camera(upright([(0.0, y, 0.0, 0.05, 0.05, 0.05) for y in (0.0, 0.1)])).center
    assert heights[1, 1] < heights[0, 1]
    assert torch.allclose(heights[1] - heights[0], 0.1 * view.up_camera(), atol=EXACT)


def test_the_table_s_top_is_the_plane_of_height_zero_and_the_floor_is_75_cm_below(
    upright: Upright, generator: torch.Generator
) -> None:
    view = draw_view(generator, upright(PILE))
    rooms = [furnish(generator, view) for _ in range(20)]
    assert {len(room) for room in rooms} == {2, 3}
    for room in rooms:
        tops = room.corners()[:2, :, 1].amax(dim=1)
        assert torch.allclose(tops, torch.tensor([0.0, -0.75], dtype=torch.float64), atol=EXACT)


def test_a_wall_is_behind_the_table_as_the_camera_sees_it(
    upright: Upright, generator: torch.Generator
) -> None:
    for _ in range(20):
        view = draw_view(generator, upright(PILE))
        room = furnish(generator, view)
        if len(room) == 3:
            toward = room.center[2] - torch.tensor([0.0, 0.5, 0.0], dtype=torch.float64)
            assert float((toward * view.center).sum()) < 0
            assert float(room.local(view.center.expand(3, 1, 3))[2, 0, 2]) < -0.5
