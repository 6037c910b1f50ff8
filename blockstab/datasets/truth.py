"""What is known about a scene and its objects, and how meta.json says it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import torch
from torch import Tensor

LARGEST_ID = 65535  # what a 16-bit label image can hold
_SKEW = 1e-3  # how far a pose written with few digits may be from rigid


@dataclass(frozen=True)
class ObjectTruth:
    """What is known about one object; None where the scene does not say.

    Args:
        id: its label id.
        kind: "box", "cylinder" or "sphere".
        half_extent: (3,) float64, metres along its own axes.
        pose_camera: (4, 4) float64, object to camera frame; the columns of its rotation are its axes.
        supported_by: label ids of what carries it, background among them.
        falls_if_removed: label ids of the objects that move when this one is taken away.
    """

    id: int
    kind: str | None = None
    half_extent: Tensor | None = None
    pose_camera: Tensor | None = None
    supported_by: tuple[int, ...] | None = None
    falls_if_removed: tuple[int, ...] | None = None


@dataclass(frozen=True)
class Truth:
    """What is known about a scene.

    Args:
        background_ids: label ids of table, floor, walls.
        objects: one entry per object, also for those that the camera does not see.
        up_camera: (3,) float64 true up direction in the camera frame, or None.
        support_annotated: whether every support of every object is given.
    """

    background_ids: tuple[int, ...]
    objects: tuple[ObjectTruth, ...]
    up_camera: Tensor | None
    support_annotated: bool


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
    ids = [o.id for o in objects]
    repeated = [i for n, i in enumerate(ids) if i in ids[:n] or i in background]
    if repeated:
        raise ValueError(f"id {repeated[0]} is given to two objects, or to an object and the background")
    for o in objects:
        others = {*ids, *background} - {o.id}
        strangers = {*(o.supported_by or ()), *(o.falls_if_removed or ())} - others
        if strangers:
            raise ValueError(
                f"object {o.id} refers to id {min(strangers)}, no other object and no background"
            )
    complete = bool(objects) and all(o.supported_by is not None for o in objects)
    annotated = meta.get("support_annotated", complete)
    if not isinstance(annotated, bool):
        raise ValueError(f"support_annotated must be true or false, but is {annotated!r}")
    up = None if meta.get("up_camera") is None else _numbers(meta["up_camera"], (3,), "up_camera")
    return Truth(background, objects, up, annotated)


def _object(entry: Mapping[str, Any], position: int) -> ObjectTruth:
    if "id" not in entry:
        raise ValueError(f"entry {position} of objects has no id")
    (own,) = _ids([entry["id"]], f"the id in entry {position} of objects")
    of = f"of object {own}"
    kind = entry.get("kind")
    if kind is not None and not isinstance(kind, str):
        raise ValueError(f"kind {of} must be a word, but is {kind!r}")
    given = {name: value for name, value in entry.items() if value is not None}
    numbers = {
        name: _numbers(given[name], shape, f"{name} {of}")
        for name, shape in (("half_extent", (3,)), ("pose_camera", (4, 4)))
        if name in given
    }
    if "half_extent" in numbers and not bool((numbers["half_extent"] > 0).all()):
        raise ValueError(f"half_extent {of} must be positive, but is {given['half_extent']}")
    if "pose_camera" in numbers and not _is_rigid(numbers["pose_camera"]):
        raise ValueError(f"pose_camera {of} must be a rotation, a shift and a last row 0 0 0 1")
    ids = {n: _ids(given[n], f"{n} {of}") for n in ("supported_by", "falls_if_removed") if n in given}
    return ObjectTruth(
        own,
        kind,
        numbers.get("half_extent"),
        numbers.get("pose_camera"),
        ids.get("supported_by"),
        ids.get("falls_if_removed"),
    )


def _is_rigid(pose: Tensor) -> bool:
    rotation = pose[:3, :3]
    last = torch.tensor([0, 0, 0, 1], dtype=pose.dtype)
    skew = torch.cat([(rotation.T @ rotation - torch.eye(3, dtype=pose.dtype)).flatten(), pose[3] - last])
    return float(skew.abs().max()) < _SKEW and float(torch.linalg.det(rotation)) > 0


def _ids(value: object, what: str) -> tuple[int, ...]:
    ok = isinstance(value, list) and all(type(i) is int and 0 < i <= LARGEST_ID for i in value)
    if not ok:
        raise ValueError(f"{what} must be label ids, whole numbers from 1 to {LARGEST_ID}, but is {value!r}")
    return tuple(value)  # type: ignore[arg-type]


def _numbers(value: object, shape: tuple[int, ...], what: str) -> Tensor:
    try:
        numbers = torch.tensor(value, dtype=torch.float64)
    except (TypeError, ValueError, RuntimeError):
        numbers = torch.empty(0, dtype=torch.float64)
    if tuple(numbers.shape) != shape or not bool(numbers.isfinite().all()):
        raise ValueError(f"{what} must be finite numbers of shape {shape}, but is {value!r}")
    return numbers
