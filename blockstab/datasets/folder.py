"""Scene folders on disk: the truth that one holds, and how one is written."""

from __future__ import annotations

import glob
import json
import os
import shutil
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import torch
from PIL import Image
from torch import Tensor

from blockstab.datasets.truth import LARGEST_ID, ObjectTruth, Truth, parsed_truth
from blockstab.rgbd.frame import Camera, Frame, check_same_size
from blockstab.rgbd.noise import KINECT
from blockstab.rgbd.reading import FrameError, depth_file, label_file, read_meta

META = "meta.json"
IMAGES = ("color.png", "depth.png", "label.png")
BOUNDARY = "boundary.png"
_RIGHT, _BELOW = (
    85,
    170,
)  # values of boundary.png, whose sum 255 means both; all three can be told apart by eye


def scene_folders(root: Path) -> list[Path]:
    """The scene folders right under `root`, sorted by name.

    Hidden folders are left out: a scene is written in one before it gets its name.
    """
    return sorted(m.parent for m in Path(root).glob(f"*/{META}") if not m.parent.name.startswith("."))


def read_truth(folder: Path) -> Truth:
    """Read what a scene's meta.json says about its objects, and its boundary.png where there is one.

    Raises:
        FrameError: a file is missing or malformed; the message is one line that names it.
    """
    file, boundary = Path(folder) / META, Path(folder) / BOUNDARY
    truth = _said(file)
    return replace(truth, boundary=_read_boundary(boundary)) if boundary.exists() else truth


def _said(file: Path) -> Truth:
    meta = read_meta(file)
    try:
        return parsed_truth(meta.values)
    except ValueError as error:
        raise FrameError(f"{file}: {error}; correct it.") from None


def _read_boundary(path: Path) -> Tensor:
    file = label_file(path)
    check_same_size(file, depth_file(path.with_name("depth.png")))
    values = torch.from_numpy(np.array(file.decode())).long()
    known = torch.isin(values, torch.tensor([0, _RIGHT, _BELOW, _RIGHT + _BELOW]))
    if not bool(known.all()):
        raise FrameError(
            f"{path}: must hold 0, {_RIGHT} (boundary to the right), {_BELOW} (below) or {_RIGHT + _BELOW} "
            f"(both), but holds {int(values[~known][0])}; leave it out, or write it so."
        )
    bits = values // _RIGHT
    return torch.stack([bits % 2 == 1, bits >= 2])


def write_scene(folder: Path, frame: Frame, truth: Truth, extra: Mapping[str, Any]) -> None:
    """Write a scene folder: color.png, depth.png (mm), label.png and boundary.png where known, and meta.json.

    The folder appears whole or not at all, and replaces one of the same name. Each object of meta.json also
    gets `pixels`, the number of pixels that carry its label.

    Args:
        folder: where; its parents are made.
        frame: images and camera; its depth is rounded to whole millimetres.
        truth: background, objects and up direction; those of `frame` are not used.
        extra: further keys of meta.json.

    Raises:
        ValueError: depth or labels do not fit 16 bits, or `extra` holds a key of the format.
    """
    meta = _meta(frame, truth)
    clash = sorted(meta.keys() & extra.keys())
    if clash:
        raise ValueError(
            f"The scene format of meta.json defines {clash[0]!r}; give the extra key another name."
        )
    depth_mm = _sixteen_bit(1000.0 * frame.depth, "depth in mm")
    images = {"color.png": frame.color.numpy(), "depth.png": depth_mm}
    if frame.label is not None:
        images["label.png"] = _sixteen_bit(frame.label, "label ids")
    if truth.boundary is not None:
        right, below = truth.boundary.to(torch.uint8)
        images[BOUNDARY] = (_RIGHT * right + _BELOW * below).numpy()
    folder = Path(folder)
    # Workers of a killed run may still be writing; without its draft such a worker fails, mixing nothing in.
    for abandoned in folder.parent.glob(f".{glob.escape(folder.name)}.*.draft"):
        shutil.rmtree(abandoned, ignore_errors=True)
    draft = folder.with_name(f".{folder.name}.{os.getpid()}.draft")
    draft.mkdir(parents=True)
    try:
        for name, image in images.items():
            Image.fromarray(image).save(draft / name)
        (draft / META).write_text(json.dumps({**meta, **extra}, indent=1) + "\n")
        _take_place(draft, folder)
    finally:
        shutil.rmtree(draft, ignore_errors=True)


def _take_place(draft: Path, folder: Path) -> None:
    # A folder cannot be renamed onto one that holds files, so the old scene steps aside first.
    retired = folder.with_name(f".{folder.name}.retired")
    shutil.rmtree(retired, ignore_errors=True)
    if folder.exists():
        folder.replace(retired)
    draft.replace(folder)
    shutil.rmtree(retired, ignore_errors=True)


def _sixteen_bit(values: Tensor, what: str) -> np.ndarray[Any, np.dtype[np.uint16]]:
    whole = values.to(torch.float64).round()
    inside = (whole >= 0) & (whole <= LARGEST_ID)  # false for NaN too
    if not bool(inside.all()):
        worst = float(values[~inside][0])
        raise ValueError(f"A 16-bit PNG holds {what} from 0 to {LARGEST_ID}, but one pixel is {worst:g}.")
    return whole.numpy().astype(np.uint16)


def _meta(frame: Frame, truth: Truth) -> dict[str, Any]:
    meta: dict[str, Any] = {**_camera(frame.camera), "depth_unit": "mm"}
    if truth.up_camera is not None:
        meta["up_camera"] = truth.up_camera.tolist()
    meta["background_ids"] = list(truth.background_ids)
    meta["objects"] = [_entry(o, frame.label) for o in truth.objects]
    meta["support_annotated"] = truth.support_annotated
    return meta


def _camera(camera: Camera) -> dict[str, Any]:
    noise = {} if camera.noise == KINECT else {"depth_noise": vars(camera.noise)}
    return {**camera.intrinsics, **noise}


def _entry(truth: ObjectTruth, label: Tensor | None) -> dict[str, Any]:
    # A scene says of few objects that they are hardly seen, so it is silent about the others.
    known = {n: v for n, v in vars(truth).items() if v is not None and (n != "hardly_seen" or v)}
    entry = {n: v.tolist() if isinstance(v, Tensor) else v for n, v in known.items()}
    if label is not None:
        entry["pixels"] = int((label == truth.id).sum())
    return entry
