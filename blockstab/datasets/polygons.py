"""Objects outlined by polygons, as in annotations of SUN RGB-D and LabelMe."""

from __future__ import annotations

from pathlib import Path
from reprlib import repr as shown
from typing import Any

import numpy as np
import torch
from PIL import Image, ImageDraw
from torch import Tensor

from blockstab.datasets.truth import LARGEST_ID
from blockstab.rgbd.reading import FrameError, read_meta

_MOST_POLYGONS = 4096
_FARTHEST = 1e5  # pixels
# Corners times pixels: painting takes longer with each, up to about a second here.
_MOST_WORK = 1e10
_NARROWEST = 512  # pixels of a row that take as long as the row itself


def polygon_labels(path: Path, shape: tuple[int, ...]) -> tuple[Tensor, dict[int, str | None]]:
    """Paint polygons one over the other, in the order of the file.

    Args:
        path: JSON with `objects`, a list of {name} or null, and `frames`, whose first holds `polygon`, a list of
            {object, x, y}: the place of the object in that list, and the corners. A polygon is left out if its
            object lies beyond the end of the list, or if it has fewer than three corners.
        shape: (H, W) of the image.

    Returns:
        (H, W) int64, 0 = none: the place of the object, counted from 1; and the names by that number, in small
        letters and less what tells parts or copies apart ("Chair2:occluded" is "chair"), None where there is none.

    Raises:
        FrameError: the file is missing, over 16 MiB, or damaged, or has too many corners for such an image.
    """
    values = read_meta(path).values
    frames, things = values.get("frames"), values.get("objects")
    first = frames[0] if isinstance(frames, list) and frames else None
    polygons = first.get("polygon", []) if isinstance(first, dict) else None
    if not isinstance(things, list) or not isinstance(polygons, list) or len(polygons) > _MOST_POLYGONS:
        raise FrameError(
            f"{path}: must hold objects, and a frame of at most {_MOST_POLYGONS} polygons, but does not; "
            "copy it again."
        )
    outlines = [_outline(polygon, path) for polygon in polygons]
    drawn = [(number, o) for number, o in outlines if number <= min(len(things), LARGEST_ID) and len(o) > 2]
    corners, most = sum(len(o) for _, o in drawn), _MOST_WORK / (shape[0] * max(shape[1], _NARROWEST))
    if corners > most:
        raise FrameError(
            f"{path}: polygons on {shape[1]} x {shape[0]} pixels must have at most {most:.0f} corners, but have "
            f"{corners}; scale the images down, and the polygons with them."
        )
    image = Image.new("I", (shape[1], shape[0]))
    pen = ImageDraw.Draw(image)
    for number, outline in drawn:
        pen.polygon(outline, fill=number)
    names = {i: _name(thing) for i, thing in enumerate(things[:LARGEST_ID], start=1)}
    return torch.from_numpy(np.array(image)).to(torch.int64), names


def _outline(polygon: Any, path: Path) -> tuple[int, list[tuple[float, float]]]:
    """The number of the object from 1, and the corners, x and y in pixels."""
    said = polygon if isinstance(polygon, dict) else {}
    place: Any = said.get("object")
    # Tools that make these files write one corner as a bare number, and none as null.
    x, y = ([] if v is None else v if isinstance(v, list) else [v] for v in (said.get("x"), said.get("y")))
    known = type(place) is int and place >= 0
    numbers = all(type(v) in (int, float) and abs(v) <= _FARTHEST for v in (*x, *y))
    if not (known and numbers and len(x) == len(y)):
        raise FrameError(
            f"{path}: a polygon must give the place of its object and have as many x as y, but is {shown(polygon)}; "
            "copy it again."
        )
    return place + 1, list(zip(x, y, strict=True))


def _name(thing: Any) -> str | None:
    name = thing.get("name") if isinstance(thing, dict) else None
    return name.lower().split(":")[0].rstrip("0123456789 ").strip() or None if isinstance(name, str) else None
