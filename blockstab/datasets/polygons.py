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

_MOST_POLYGONS, _MOST_CORNERS = 4096, 65536  # of an image, and of all its polygons
_FARTHEST = 1e5  # pixels


def polygon_labels(path: Path, shape: tuple[int, ...]) -> tuple[Tensor, dict[int, str]]:
    """Paint polygons one over the other, in the order of the file.

    Args:
        path: JSON with `objects`, a list of {name} or null, and `frames`, whose first holds `polygon`, a list of
            {object, x, y}: the place of the object in that list, and the corners.
        shape: (H, W) of the image.

    Returns:
        (H, W) int64, 0 = none: the place of the object, counted from 1; and the names by that number, in small
        letters.

    Raises:
        FrameError: the file is missing, over 16 MiB, or damaged.
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
    image = Image.new("I", (shape[1], shape[0]))
    pen, corners = ImageDraw.Draw(image), 0
    for polygon in polygons:
        number, outline = _outline(polygon, len(things), path)
        corners += len(outline)
        if corners > _MOST_CORNERS:
            raise FrameError(f"{path}: polygons must have at most {_MOST_CORNERS} corners; copy it again.")
        if len(outline) > 2:
            pen.polygon(outline, fill=number)
    names = {i: _name(thing) for i, thing in enumerate(things[:LARGEST_ID], start=1)}
    return torch.from_numpy(np.array(image)).to(torch.int64), names


def _outline(polygon: Any, things: int, path: Path) -> tuple[int, list[tuple[float, float]]]:
    """The number of the object from 1, and the corners, x and y in pixels."""
    said = polygon if isinstance(polygon, dict) else {}
    place: Any = said.get("object")
    # Tools that make these files write one corner as a bare number, and none as null.
    x, y = ([] if v is None else v if isinstance(v, list) else [v] for v in (said.get("x"), said.get("y")))
    known = isinstance(place, int) and not isinstance(place, bool) and 0 <= place < min(things, LARGEST_ID)
    numbers = all(type(v) in (int, float) and abs(v) <= _FARTHEST for v in (*x, *y))
    if not (known and numbers and len(x) == len(y)):
        raise FrameError(
            f"{path}: a polygon must name one of {things} objects and have as many x as y, but is {shown(polygon)}; "
            "copy it again."
        )
    return int(place) + 1, list(zip(x, y, strict=True))


def _name(thing: Any) -> str:
    name = thing.get("name") if isinstance(thing, dict) else None
    return name.lower() if isinstance(name, str) else ""
