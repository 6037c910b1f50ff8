"""Ground truth of a scene and its objects, and its form in meta.json."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass
from reprlib import repr as shown
from typing import Any

import torch
from torch import Tensor

MIN_VISIBLE_PX = 100  # objects of which fewer pixels are seen are not scored
LARGEST_ID = 65535  # what a 16-bit label image can hold
SUPPORT_TYPES = ("surface", "partial", "side", "below", "behind")
_SKEW = 1e-3  # how far a pose written with few digits may be from rigid


@dataclass(frozen=True)
class ObjectTruth:
    """Ground truth of one object; None where the scene does not say.

    Args:
        id: its label id.
        kind: its shape: "box", "cylinder", "sphere", "bowl", "bottle", "l_shape", "screen", "laptop",
            "mouse".
        half_extent: (3,) float64, metres along its own axes.
        pose_camera: (4, 4) float64, object to camera frame; the columns of its rotation are its axes.
        supported_by: label ids of what carries it, background among them.
        falls_if_removed: label ids of the objects that move when this one is taken away.
        support_types: how each of `supported_by` carries it: "surface", "partial" or "side", or, where the
            truth says no more than that, "below" or "behind".
        category: what it is, in the words of its set.
        total_pixels: how many pixels it would cover in the image if nothing stood in front of it.
        hardly_seen: whether so few of its pixels are seen that it should not be scored.
        moves: whether it moves, let go where it is; None where all is at rest, as in photographs.
    """

    id: int
    kind: str | None = None
    half_extent: Tensor | None = None
    pose_camera: Tensor | None = None
    supported_by: tuple[int, ...] | None = None
    falls_if_removed: tuple[int, ...] | None = None
    support_types: tuple[str, ...] | None = None
    category: str | None = None
    total_pixels: int | None = None
    hardly_seen: bool = False
    moves: bool | None = None


@dataclass(frozen=True)
class Truth:
    """Ground truth of a scene.

    Args:
        background_ids: label ids of table, floor, walls.
        objects: one entry per object, also for those that the camera does not see.
        up_camera: (3,) float64 true up direction in the camera frame, or None.
        support_annotated: whether every support of every object is given.
        boundary: (2, H, W) bool, whether a pixel shows another thing than its right neighbour, and than the
            one below it; also where depth is missing. None where only the labels tell.
    """

    background_ids: tuple[int, ...]
    objects: tuple[ObjectTruth, ...]
    up_camera: Tensor | None
    support_annotated: bool
    boundary: Tensor | None = None


def parsed_truth(meta: Mapping[str, Any]) -> Truth:
    """The truth that the keys of a meta.json give.

    Where `support_annotated` is missing, it holds if there are objects and each gives its supporters.

    Raises:
        ValueError: a key is malformed, or an id is given twice or refers to nothing.
    """
    background = _ids(meta.get("background_ids", []), "background_ids")
    entries = meta.get("objects", [])
    if not (isinstance(entries, list) and all(isinstance(e, dict) for e in entries)):
        raise ValueError("objects must be a list of JSON objects")
    objects = tuple(_object(entry, i) for i, entry in enumerate(entries))
    uses = Counter([*(o.id for o in objects), *set(background)])
    repeated, used = uses.most_common(1)[0] if uses else (0, 0)
    if used > 1:
        raise ValueError(f"id {repeated} is given to two objects, or to an object and the background")
    for o in objects:
        referred = {*(o.supported_by or ()), *(o.falls_if_removed or ())}
        strangers = {i for i in referred if i not in uses or i == o.id}
        if strangers:
            raise ValueError(
                f"object {o.id} refers to id {min(strangers)}, no other object and no background"
            )
    complete = bool(objects) and all(o.supported_by is not None for o in objects)
    annotated = meta.get("support_annotated", complete)
    if not isinstance(annotated, bool):
        raise ValueError(f"support_annotated must be true or false, but is {shown(annotated)}")
    up = None if meta.get("up_camera") is None else _numbers(meta["up_camera"], (3,), "up_camera")
    return Truth(background, objects, up, annotated)


def _object(entry: Mapping[str, Any], position: int) -> ObjectTruth:
    if "id" not in entry:
        raise ValueError(f"entry {position} of objects has no id")
    (own,) = _ids([entry["id"]], f"the id in entry {position} of objects")
    of = f"of object {own}"
    for word in ("kind", "category"):
        if not isinstance(entry.get(word), str | None):
            raise ValueError(f"{word} {of} must be a word, but is {shown(entry[word])}")
    given = {name: value for name, value in entry.items() if value is not None}
    numbers = {
        name: _numbers(given[name], shape, f"{name} {of}")
        for name, shape in (("half_extent", (3,)), ("pose_camera", (4, 4)))
        if name in given
    }
    if "half_extent" in numbers and not bool((numbers["half_extent"] > 0).all()):
        raise ValueError(f"half_extent {of} must be positive, but is {shown(given['half_extent'])}")
    if "pose_camera" in numbers and not _is_rigid(numbers["pose_camera"]):
        raise ValueError(f"pose_camera {of} must be a rotation, a shift and a last row 0 0 0 1")
    ids: dict[str, tuple[int, ...]] = {
        n: _ids(given[n], f"{n} {of}") for n in ("supported_by", "falls_if_removed") if n in given
    }
    return ObjectTruth(
        own,
        given.get("kind"),
        numbers.get("half_extent"),
        numbers.get("pose_camera"),
        ids.get("supported_by"),
        ids.get("falls_if_removed"),
        _types(given, ids, of),
        given.get("category"),
        _pixels(given, of),
        given.get("hardly_seen") is True,
        _flag(given, "moves", of),
    )


def _flag(given: Mapping[str, Any], key: str, of: str) -> bool | None:
    value = given.get(key)
    if not isinstance(value, bool | None):
        raise ValueError(f"{key} {of} must be true or false, but is {shown(value)}")
    return value


def _types(given: Mapping[str, Any], ids: Mapping[str, tuple[int, ...]], of: str) -> tuple[str, ...] | None:
    if "support_types" not in given:
        return None
    types, supporters = given["support_types"], ids.get("supported_by", ())
    if (
        not isinstance(types, list)
        or len(types) != len(supporters)
        or not all(t in SUPPORT_TYPES for t in types)
    ):
        raise ValueError(
            f"support_types {of} must be one of {', '.join(SUPPORT_TYPES)} for each supporter, but is {shown(types)}"
        )
    return tuple(types)


def _pixels(given: Mapping[str, Any], of: str) -> int | None:
    count = given.get("total_pixels")
    if count is not None and (type(count) is not int or count < 0):
        raise ValueError(f"total_pixels {of} must be a whole number from 0, but is {shown(count)}")
    return count


def _is_rigid(pose: Tensor) -> bool:
    rotation = pose[:3, :3]
    last = torch.tensor([0, 0, 0, 1], dtype=pose.dtype)
    skew = torch.cat([(rotation.T @ rotation - torch.eye(3, dtype=pose.dtype)).flatten(), pose[3] - last])
    return float(skew.abs().max()) < _SKEW and float(torch.linalg.det(rotation)) > 0


def _ids(value: object, what: str) -> tuple[int, ...]:
    ok = isinstance(value, list) and all(type(i) is int and 0 < i <= LARGEST_ID for i in value)
    if not ok:
        raise ValueError(
            f"{what} must be label ids, whole numbers from 1 to {LARGEST_ID}, but is {shown(value)}"
        )
    return tuple(value)  # type: ignore[arg-type]


def _numbers(value: object, shape: tuple[int, ...], what: str) -> Tensor:
    try:
        numbers = torch.tensor(value, dtype=torch.float64)
    except (TypeError, ValueError, RuntimeError, OverflowError):
        numbers = torch.empty(0, dtype=torch.float64)
    if tuple(numbers.shape) != shape or not bool(numbers.isfinite().all()):
        raise ValueError(f"{what} must be finite numbers of shape {shape}, but is {shown(value)}")
    return numbers
