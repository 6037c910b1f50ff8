"""Masks from JSON, as COCO and Segment Anything write them."""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path
from reprlib import repr as shown
from typing import Any

from blockstab.proposals.masks import Mask, check_count
from blockstab.proposals.rle import inside, run_lengths
from blockstab.rgbd.reading import FrameError, finite, read_json

_SCORES = ("score", "predicted_iou")


def annotated_masks(path: Path, height: int, width: int) -> Iterator[Mask]:
    """The masks of one image, one by one.

    Args:
        path: JSON of at most 16 MiB: a list of objects, or an object with such a list as `annotations`. Each has a
            `segmentation` in run lengths, and may have a `score` (COCO) or a `predicted_iou` (Segment Anything);
            what else it has is not looked at.
        height, width: of the image.

    Raises:
        FrameError: the file is not that, or holds masks of several images or of another size.
    """
    annotations = _annotations(path)
    check_count(path, len(annotations), height, width)
    images = {shown(annotation.get("image_id")) for annotation in annotations}
    if len(images) > 1:
        raise FrameError(
            f"{path}: must hold the masks of one image, but has those of {len(images)} by their image_id; "
            "write a file for each image."
        )
    for number, annotation in enumerate(annotations, start=1):
        where = f"{path}: mask {number}"
        runs = run_lengths(annotation.get("segmentation"), height, width, where)
        yield Mask(number, inside(runs, height, width), _score(annotation, where))


def _annotations(path: Path) -> list[dict[str, Any]]:
    values = read_json(path)
    listed = values.get("annotations") if isinstance(values, dict) else values
    if not isinstance(listed, list) or not all(isinstance(annotation, dict) for annotation in listed):
        raise FrameError(
            f"{path}: must be a list of objects, or an object with such a list as annotations, but it is "
            f"{shown(values)[:80]}; write one object for each mask."
        )
    return listed


def _score(annotation: dict[str, Any], where: str) -> float | None:
    name = next((name for name in _SCORES if name in annotation), None)
    if name is None:
        return None
    score = finite(annotation[name])
    if math.isnan(score):
        raise FrameError(
            f"{where}: {name} must be a finite number, but it is {shown(annotation[name])[:80]}; "
            "correct it, or leave it out."
        )
    return score
