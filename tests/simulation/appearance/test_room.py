"""The furniture, which must not touch or hide what stands on it."""

from __future__ import annotations

import pytest
import torch

from blockstab.boxes.separation import separation
from blockstab.simulation.appearance.raycasting import RayCaster
from blockstab.simulation.appearance.room import furnish
from blockstab.simulation.appearance.viewpoint import Setting, Viewpoint, draw_view
from blockstab.simulation.physics.solids import Pile
from tests.simulation.scenery import KINECT, of_one_part, standing
from tests.tolerance import EXACT

PILE = standing(
    (of_one_part("box", (0.1, 0.15, 0.04), "carton"), -0.35, 0.2),
    (of_one_part("cylinder", (0.05, 0.06, 0.05), "tin"), 0.3, -0.25),
    (of_one_part("box", (0.04, 0.3, 0.04), "block"), 0.0, 0.0),
)


@pytest.fixture(scope="module", params=["table", "shelf", "room"])
def rooms(request: pytest.FixtureRequest) -> list[tuple[Viewpoint, Pile]]:
    """Twenty rooms of a setting, each with a view of it."""
    setting: Setting = request.param
    generator = torch.Generator().manual_seed(3)
    views = [draw_view(generator, PILE, KINECT, setting) for _ in range(20)]
    return [(view, furnish(generator, view, PILE, setting)) for view in views]


def test_the_first_piece_is_the_table_or_the_floor_and_its_top_is_at_height_zero(
    rooms: list[tuple[Viewpoint, Pile]],
) -> None:
    for _, room in rooms:
        assert room.solids[0].style in ("table", "floor")
        corners = room.boxes().corners()[0]
        assert abs(float(corners[:, 1].max())) < EXACT
        feet = PILE.boxes().corners()[..., [0, 2]].flatten(0, 1)
        assert (feet > corners[:, [0, 2]].amin(dim=0)).all()
        assert (feet < corners[:, [0, 2]].amax(dim=0)).all()


def test_nothing_else_comes_near_the_pile(rooms: list[tuple[Viewpoint, Pile]]) -> None:
    pile = PILE.boxes()
    for _, room in rooms:
        for boxes in (room.boxes()[[i]] for i in range(1, len(room))):
            both = type(boxes)(
                *(
                    torch.cat([getattr(b, k) for b in (boxes, pile)])
                    for k in ("center", "rotation", "half_extent")
                )
            )
            gaps = separation(both, torch.zeros(3, dtype=torch.int64), torch.arange(1, 4)).gap
            assert float(gaps.min()) > 0.005


def test_nothing_stands_between_the_camera_and_the_pile(rooms: list[tuple[Viewpoint, Pile]]) -> None:
    corners = PILE.boxes().corners().flatten(0, 1) + torch.tensor([0.0, 1e-4, 0.0], dtype=torch.float64)
    for view, room in rooms:
        assert not RayCaster(room).hidden_from(view.center.expand_as(corners), corners).any()


@pytest.mark.parametrize("rooms", ["table", "shelf"], indirect=True)
def test_what_stands_round_tables_and_shelves_differs_and_walls_are_common(
    rooms: list[tuple[Viewpoint, Pile]],
) -> None:
    styles = [tuple(solid.style for solid in room.solids) for _, room in rooms]
    assert all(style[1] == "floor" for style in styles)
    assert sum("wall" in style for style in styles) >= 9
    assert len(set(styles)) >= 4
    assert {name for style in styles for name in style} == {"table", "floor", "wall", "shelf"}
