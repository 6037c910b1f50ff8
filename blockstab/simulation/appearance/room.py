"""The furniture round a pile: a table in a room, a shelf, or the room itself."""

from __future__ import annotations

import math
from collections.abc import Callable

import torch

from blockstab.simulation.appearance.viewpoint import Setting, Viewpoint
from blockstab.simulation.layouts.placing import about_up
from blockstab.simulation.physics.solids import Pile, box

_TABLE_HEIGHT = 0.75  # metres above the floor
_BOARD = 0.012  # metres, half the thickness of boards, walls and floor
_FREE = 0.03  # metres at least between the pile and what stands beside it

Row = tuple[str, tuple[float, float, float], tuple[float, float, float], float]


def furnish(generator: torch.Generator, view: Viewpoint, pile: Pile, setting: Setting = "table") -> Pile:
    """Table, floor and, at times, walls, boards and a cabinet, none of them in front of the pile.

    The first piece is what the pile stands on: its top is the plane y = 0. Only that touches the pile, and
    every other piece lies beyond a plane that has pile and camera on its other side.

    Returns:
        Solids of the styles "table", "floor", "wall" and "shelf", in the table frame.
    """
    share = torch.rand(25, generator=generator, dtype=torch.float64).tolist()
    rows = _ROUND.get(setting, _table_room)(share, view, pile)
    styles, centers, halves, yaws = zip(*rows, strict=True)
    return Pile(
        tuple(box(half, style) for half, style in zip(halves, styles, strict=True)),
        torch.tensor(centers, dtype=torch.float64),
        about_up(torch.tensor(yaws, dtype=torch.float64)),
    )


def _table_room(share: list[float], view: Viewpoint, pile: Pile) -> list[Row]:
    reach = float(pile.boxes().corners()[..., [0, 2]].norm(dim=-1).max()) + _FREE
    half_x, half_z = (max(reach, 0.5 + 0.6 * s) for s in share[:2])
    rows: list[Row] = [
        ("table", (0.0, -_BOARD, 0.0), (half_x, _BOARD, half_z), 0.0),
        ("floor", (0.0, -_TABLE_HEIGHT - _BOARD, 0.0), (5.0, _BOARD, 5.0), 0.0),
    ]
    behind = math.atan2(-float(view.center[0]), -float(view.center[2]))
    if share[2] < 2 / 3:
        away, far = behind + 0.6 * share[3] - 0.3, max(reach, 0.9) + 1.2 * share[4]
        rows.append(("wall", (far * math.sin(away), 0.8, far * math.cos(away)), (5.0, 2.0, _BOARD), away))
    for s in (share[k : k + 5] for k in range(5, 25, 5)):
        if s[0] < 0.5:
            half = (0.12 + 0.5 * s[1] ** 2, 0.15 + 0.5 * s[2], 0.2)
            away, far = behind + 1.6 * s[3] - 0.8, reach + max(half[0], half[2]) + 1.5 * s[4]
            place = (far * math.sin(away), half[1] - _TABLE_HEIGHT, far * math.cos(away))
            rows.append(("shelf", place, half, away))
    return rows


def _shelf(share: list[float], view: Viewpoint, pile: Pile) -> list[Row]:
    corners = pile.boxes().corners().flatten(0, 1)
    low, high = corners.amin(dim=0).tolist(), corners.amax(dim=0).tolist()
    back, front = low[2] - _FREE - 0.05 * share[0], high[2] + 0.01 + 0.1 * share[1]
    middle, deep, wide = (front + back) / 2, (front - back) / 2, 1.5
    x, y, _ = view.center.tolist()
    rows: list[Row] = [
        ("table", (0.0, -_BOARD, middle), (wide, _BOARD, deep), 0.0),
        ("floor", (0.0, -0.5 - 0.5 * share[2], front), (5.0, _BOARD, 5.0), 0.0),
        ("wall", (0.0, 0.5, back - _BOARD), (5.0, 2.0, _BOARD), 0.0),
    ]
    for side, chance, gap in ((-1.0, share[3], share[4]), (1.0, share[5], share[6])):
        edge = max(side * low[0], side * high[0]) + _FREE + 0.2 * gap
        if chance < 0.5 and side * x < edge:
            rows.append(("shelf", (side * (edge + _BOARD), 0.4, middle), (_BOARD, 0.5, deep), 0.0))
    if share[7] < 0.6:
        # From below its lower side, a board above hides nothing that is below it, too.
        under = max(high[1] + _FREE, y) + 0.1 * share[8]
        rows.append(("shelf", (0.0, under + _BOARD, middle), (wide, _BOARD, deep), 0.0))
    if share[9] < 0.5:
        rows.append(("shelf", (0.0, -0.3 - 0.15 * share[10], middle), (wide, _BOARD, deep), 0.0))
    return rows


def _walls(share: list[float], view: Viewpoint, pile: Pile) -> list[Row]:
    """A floor, and behind the pile the two walls of a corner, or one."""
    reach = float(pile.boxes().corners()[..., [0, 2]].norm(dim=-1).max()) + _FREE
    behind = math.atan2(-float(view.center[0]), -float(view.center[2]))
    rows: list[Row] = [("floor", (0.0, -_BOARD, 0.0), (6.0, _BOARD, 6.0), 0.0)]
    turn = math.pi / 4 * (2 * share[0] - 1)
    for away, far in (
        (behind + turn, share[1]),
        (behind + turn - math.copysign(math.pi / 2, turn), share[2]),
    ):
        distance = reach + _BOARD + 0.6 * far
        place = (distance * math.sin(away), 1.3, distance * math.cos(away))
        rows.append(("wall", place, (6.0, 1.3, _BOARD), away))
    return rows


_ROUND: dict[Setting, Callable[[list[float], Viewpoint, Pile], list[Row]]] = {"shelf": _shelf, "room": _walls}
