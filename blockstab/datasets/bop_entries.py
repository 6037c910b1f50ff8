"""Entries of an image in the JSON files of a BOP set, checked."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from reprlib import repr as shown
from typing import Any

import torch
from torch import Tensor

from blockstab.datasets.truth import LARGEST_ID
from blockstab.rgbd.frame import Camera
from blockstab.rgbd.reading import FrameError, Meta


def bounds(models: Meta, model: int) -> tuple[Tensor, Tensor] | None:
    """Lowest corner and extent (3,) of a model's bounding box, metres; None where the file has no such model."""
    name, file = str(model), models.path
    if name not in models.values:
        return None
    said = Meta(file, json_object(models.values[name], file))
    low, size = ([said.number(f"{word}_{axis}") / 1000.0 for axis in "xyz"] for word in ("min", "size"))
    if min(size) <= 0:
        raise FrameError(
            f"{file}: sizes of model {shown(name)} must be above 0, but one is {min(size)}; copy it again."
        )
    return torch.tensor(low, dtype=torch.float64), torch.tensor(size, dtype=torch.float64)


def camera_of(said: Meta, stem: str) -> tuple[Camera, float]:
    """Intrinsics, and millimetres of one step of the depth image."""
    entry = json_object(said.values.get(str(int(stem))), said.path)
    k = numbers(entry, "cam_K", 9, said.path).tolist()
    scale = Meta(said.path, entry).number("depth_scale")
    if not 0 < scale < 1e3:
        raise FrameError(
            f"{said.path}: depth_scale must be above 0 and below 1000, but is {scale}; correct it."
        )
    return Camera(k[0], k[4], k[2], k[5]), scale


def entries(said: Meta, stem: str) -> list[dict[str, Any]]:
    """The entries of a file for an image; none where it does not list the image."""
    listed = said.values.get(str(int(stem)), [])
    if not isinstance(listed, list) or len(listed) > LARGEST_ID:
        raise FrameError(
            f"{said.path}: image {stem} must have a list of objects, but has {shown(listed)}; copy it again."
        )
    return [json_object(entry, said.path) for entry in listed]


def json_object(entry: object, file: Path) -> dict[str, Any]:
    """The entry; FrameError where it is no object."""
    if not isinstance(entry, dict):
        raise FrameError(
            f"{file}: each image and object must be a JSON object, but one is {shown(entry)}; copy it again."
        )
    return entry


def numbers(entry: Mapping[str, Any], key: str, count: int, file: Path) -> Tensor:
    """(count,) float64 finite numbers."""
    try:
        found = torch.tensor(entry.get(key), dtype=torch.float64)
    except (TypeError, ValueError, RuntimeError, OverflowError):
        found = torch.empty(0)
    if found.shape != (count,) or not bool(found.isfinite().all()):
        raise FrameError(
            f"{file}: {key} must be {count} finite numbers, but is {shown(entry.get(key))}; copy it again."
        )
    return found
