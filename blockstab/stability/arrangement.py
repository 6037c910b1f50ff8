"""Arrangements of boxes to be judged, as a file has them: our scene.json, or what anybody's detector found."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from reprlib import repr as shown
from typing import Any, NoReturn

import torch
from torch import Tensor

from blockstab.boxes.box import Boxes, checked, rotation_of
from blockstab.rgbd.ground import world_from_camera
from blockstab.rgbd.reading import FrameError, Meta, finite, read_json
from blockstab.stability.relating import related_on
from blockstab.stability.support import SupportRules, Supports

TOUCH_M = 0.005  # boxes of which nothing is known but where they are touch if they are this close
_NO_GROUND_M = 0.03  # above the ground: a background box that ends lower is the ground itself
MOST_BOXES = 500  # the square of their number is what costs


@dataclass(frozen=True)
class Arrangement:
    """N boxes in the world frame, +y up, metres.

    Args:
        ids: what the file calls them.
        boxes: where they are.
        movable: (N,) bool, the others are background.
        ground_height: y of the ground, metres.
        rules: how near boxes touch.
        slack: (N,) metres by which each may be off.
    """

    ids: tuple[str, ...]
    boxes: Boxes
    movable: Tensor
    ground_height: float
    rules: SupportRules
    slack: Tensor

    def candidates(self) -> Supports:
        """All relations that nearness allows."""
        n = len(self.boxes)
        first, second = torch.triu_indices(n, n, offset=1)
        top = self.boxes.corners()[..., 1].amax(dim=1)
        is_ground = ~self.movable & (top < self.ground_height + _NO_GROUND_M)
        return related_on(
            self.ground_height, self.boxes, (first, second), self.movable, is_ground, self.rules
        )


def read_arrangement(path: Path) -> Arrangement:
    """Read a scene.json of ours, a JSON list of boxes, or an object with `boxes` and, at will, `up` and `ground_m`.

    A box has `center` (x, y, z), `rotation` (three rows of three, whose columns are its axes) or `quaternion`
    (w, x, y, z), or neither, `size` or `half_extent`, and at will `id` and `background`. Without `up` +y is up;
    without `ground_m`, how far along it the ground is, the lowest corner lies on the ground.

    Raises:
        FrameError: the file is no such thing; it says what must hold.
    """
    values = read_json(path)
    meta = Meta(path, values if isinstance(values, dict) else {"boxes": values})
    if "segments" in meta.values:
        return _of_scene(meta)
    rows = _rows(meta, "boxes")
    up = meta.direction("up")
    turn = torch.eye(3, dtype=torch.float64) if up is None else world_from_camera(up)
    boxes = _boxes(path, rows).rotated(turn)
    lowest = float(boxes.corners()[..., 1].min())
    ground = meta.number("ground_m") if "ground_m" in meta.values else lowest
    rules = SupportRules(touch_m=TOUCH_M, touch_per_square_m=0.0)
    return _arrangement(rows, boxes, ground, rules, torch.zeros(len(rows), dtype=torch.float64))


def _of_scene(meta: Meta) -> Arrangement:
    rows = _rows(meta, "segments")
    up = meta.direction("up_camera")
    if up is None:
        raise FrameError(f"{meta.path}: must have up_camera, but has not; parse the image anew.")
    inner: list[dict[str, Any]] = [
        dict(row["box"]) if isinstance(row.get("box"), dict) else {} for row in rows
    ]
    boxes = _boxes(meta.path, inner).rotated(world_from_camera(up))
    height = meta.values.get("ground_height_m")
    lowest = float(boxes.corners()[..., 1].min())
    ground = lowest if height is None else meta.number("ground_height_m")
    rules = SupportRules()
    return _arrangement(rows, boxes, ground, rules, rules.noise(boxes))


def _arrangement(
    rows: Sequence[dict[str, Any]], boxes: Boxes, ground: float, rules: SupportRules, slack: Tensor
) -> Arrangement:
    ids = tuple(str(row.get("id", k)) for k, row in enumerate(rows))
    movable = torch.tensor([not bool(row.get("background", False)) for row in rows])
    return Arrangement(ids, boxes, movable, ground, rules, slack)


def _rows(meta: Meta, key: str) -> list[dict[str, Any]]:
    rows = meta.values.get(key)
    if not isinstance(rows, list) or not rows or not all(isinstance(row, dict) for row in rows):
        raise FrameError(
            f"{meta.path}: must hold a list of boxes, but it is {shown(rows)}; list one at least."
        )
    if len(rows) > MOST_BOXES:
        raise FrameError(
            f"{meta.path}: must hold at most {MOST_BOXES} boxes, but holds {len(rows)}; leave the others out."
        )
    ids = [str(row.get("id", k)) for k, row in enumerate(rows)]
    twice = next((i for i in ids if ids.count(i) > 1), None)
    if twice is not None:
        raise FrameError(
            f"{meta.path}: each box needs an id of its own, but {ids.count(twice)} are {twice:.80}."
        )
    return rows


def _boxes(path: Path, rows: Sequence[dict[str, Any]]) -> Boxes:
    center = torch.stack([_numbers(path, k, row, "center", 3) for k, row in enumerate(rows)])
    half = torch.stack(
        [
            _numbers(path, k, row, "size", 3) / 2
            if "size" in row
            else _numbers(path, k, row, "half_extent", 3)
            for k, row in enumerate(rows)
        ]
    )
    rotation = torch.stack([_rotation(path, k, row) for k, row in enumerate(rows)])
    try:
        return checked(Boxes(center, rotation, half))
    except ValueError as error:
        raise FrameError(f"{path}: {error}") from None


def _rotation(path: Path, k: int, row: dict[str, Any]) -> Tensor:
    if "quaternion" in row:
        q = _numbers(path, k, row, "quaternion", 4)
        if not 0.0 < float(q.norm()) < float("inf"):
            _refuse(path, k, "quaternion", "four numbers, not all zero", row["quaternion"])
        return rotation_of(q)
    if "rotation" not in row:
        return torch.eye(3, dtype=torch.float64)
    value = row["rotation"]
    if not isinstance(value, list) or len(value) != 3:
        _refuse(path, k, "rotation", "three rows of three numbers", value)
    return torch.stack([_numbers(path, k, {"rotation": part}, "rotation", 3) for part in value])


def _numbers(path: Path, k: int, row: dict[str, Any], key: str, count: int) -> Tensor:
    value = row.get(key)
    numbers = torch.tensor(
        [finite(number) for number in value] if isinstance(value, list) else [], dtype=torch.float64
    )
    if len(numbers) != count or not bool(numbers.isfinite().all()):
        _refuse(path, k, key, f"{count} finite numbers", value)
    return numbers


def _refuse(path: Path, k: int, key: str, wanted: str, came: object) -> NoReturn:
    raise FrameError(f"{path}: {key} of box {k} must be {wanted}, but it is {shown(came)}; correct it.")
