"""Where the camera stands."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import torch

from blockstab.boxes.box import Boxes
from blockstab.simulation.appearance.viewpoint import Viewpoint, draw_view
from blockstab.simulation.physics.solids import Pile
from tests.simulation.scenery import KINECT, pile_of_boxes
from tests.tolerance import EXACT

Upright = Callable[[Sequence[tuple[float, ...]]], Boxes]
PILE = [(0.1, 0.05, 0.0, 0.05, 0.05, 0.05), (-0.1, 0.1, 0.2, 0.05, 0.1, 0.05)]


def down_deg(view: Viewpoint) -> float:
    """How far the camera looks down."""
    return math.degrees(math.asin(-float(view.up_camera()[2])))


def assert_aimed(view: Viewpoint, pile: Pile) -> None:
    corners = pile.boxes().corners().flatten(0, 1)
    middle = (corners.amin(dim=0) + corners.amax(dim=0)) / 2
    ahead = view.camera_from_table @ (middle - view.center)
    assert torch.allclose(ahead[:2], torch.zeros(2, dtype=torch.float64), atol=EXACT)
    assert float((view.camera_from_table @ (corners - view.center).T).norm(dim=0).amin()) > 0.5
    assert float(ahead[2]) <= 1.4
    up = view.up_camera()
    assert abs(math.degrees(math.atan2(float(up[0]), -float(up[1])))) < 6


def test_at_a_table_the_camera_looks_down_on_the_middle_of_the_pile(
    upright: Upright, generator: torch.Generator
) -> None:
    pile = pile_of_boxes(upright(PILE))
    views = [draw_view(generator, pile, KINECT) for _ in range(20)]
    for view in views:
        assert_aimed(view, pile)
        assert 20 <= down_deg(view) <= 50
    # From all sides: into each quarter some of twenty views fall.
    quarters = {(float(v.center[0]) > 0, float(v.center[2]) > 0.1) for v in views}
    assert len(quarters) == 4


def test_at_a_shelf_the_camera_stands_in_front(upright: Upright, generator: torch.Generator) -> None:
    pile = pile_of_boxes(upright(PILE))
    middle = pile.center.mean(dim=0)
    for _ in range(20):
        view = draw_view(generator, pile, KINECT, "shelf")
        assert_aimed(view, pile)
        assert 5 <= down_deg(view) <= 25
        x, _, z = (view.center - middle).tolist()
        assert abs(math.degrees(math.atan2(x, z))) <= 35


def test_at_a_desk_some_of_the_pile_may_be_cut_off_but_not_most(
    upright: Upright, generator: torch.Generator
) -> None:
    pile = pile_of_boxes(
        upright([(x, 0.05, z, 0.05, 0.05, 0.05) for x in (-0.3, 0.0, 0.3) for z in (-0.3, 0.0, 0.3)])
    )
    shares = []
    for _ in range(30):
        view = draw_view(generator, pile, KINECT, "desk")
        assert 30 <= down_deg(view) <= 65
        column, row, depth = view.pixels(pile.boxes().corners().flatten(0, 1)).unbind(dim=1)
        inside = (column > 0) & (column < 319) & (row > 0) & (row < 239) & (depth > 0)
        shares.append(float(inside.double().mean()))
    assert min(shares) >= 0.7
    assert sum(share < 1.0 for share in shares) >= 10


def test_convention_camera_axes_are_right_handed_and_the_table_is_below(
    upright: Upright, generator: torch.Generator
) -> None:
    view = draw_view(generator, pile_of_boxes(upright(PILE)), KINECT)
    rotation = view.camera_from_table
    assert torch.allclose(rotation @ rotation.T, torch.eye(3, dtype=torch.float64), atol=EXACT)
    assert float(torch.linalg.det(rotation)) > 0
    # A point higher above the table is higher up in the picture, where y is smaller.
    heights = view.in_camera(upright([(0.0, y, 0.0, 0.05, 0.05, 0.05) for y in (0.0, 0.1)])).center
    assert heights[1, 1] < heights[0, 1]
    assert torch.allclose(heights[1] - heights[0], 0.1 * view.up_camera(), atol=EXACT)


def test_the_ray_of_a_pixel_leads_to_the_points_that_it_shows(
    upright: Upright, generator: torch.Generator
) -> None:
    view = draw_view(generator, pile_of_boxes(upright(PILE)), KINECT)
    rays = view.rays()
    assert rays.shape == (240, 320, 3)
    column, row, depth = view.pixels(view.center + 1.7 * rays[100, 200]).tolist()
    assert abs(column - 200) < 1e-6
    assert abs(row - 100) < 1e-6
    assert abs(depth - 1.7) < EXACT
