"""Features of the box of a segment beside Table 1: its sizes, where it ends, how the image fills it."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import torch
from torch import Tensor

from blockstab.boxes.box import Boxes
from blockstab.features.formulas import columns_of
from blockstab.geometry.convex_hulls import area, hull
from blockstab.rgbd.frame import Camera
from blockstab.rgbd.ground import Ground

_NEAREST = 0.05  # metres from the camera: corners closer, or behind it, count as so far away
_MIN_VOLUME = 1e-6  # cubic metres


class _Measured(NamedTuple):
    """Measurements of N boxes."""

    sizes: Tensor  # (N, 3) lengths of the edges, ascending, metres
    volume: Tensor  # (N,) cubic metres
    height: Tensor  # (N, 8) of the corners above the ground, metres
    covered: Tensor  # (N,) pixels of the box's outline in the image
    pixels: Tensor  # (N,) of the segment


_FORMULAS: dict[str, Callable[[_Measured], Tensor]] = {
    "size_least": lambda m: m.sizes[:, 0],
    "size_middle": lambda m: m.sizes[:, 1],
    "size_greatest": lambda m: m.sizes[:, 2],
    "volume_log": lambda m: m.volume.clamp(min=_MIN_VOLUME).log(),
    "bottom": lambda m: m.height.amin(dim=1),
    "top": lambda m: m.height.amax(dim=1),
    "fill_of_box": lambda m: m.pixels / m.covered.clamp(min=1.0),
}
BOX_SHAPE_COLUMNS = tuple(_FORMULAS)


def box_shape(boxes: Boxes, pixels: Tensor, camera: Camera, ground: Ground) -> Tensor:
    """Columns of N boxes, (N, 7) float64, in the order of `BOX_SHAPE_COLUMNS`.

    `size` is the length of the edges, ascending, metres; `bottom` and `top` are heights above the ground, metres;
    `fill_of_box` is the share of the box's outline in the image that the segment's pixels fill.

    Args:
        boxes: world frame; pixels: (N,) of their segments.
    """
    corners = boxes.corners()
    height = corners[..., 1] - (0.0 if ground.height is None else ground.height)
    seen = corners @ ground.world_from_camera
    depth = seen[..., 2].clamp(min=_NEAREST)
    image = torch.stack([camera.fx * seen[..., 0] / depth, camera.fy * seen[..., 1] / depth], dim=-1)
    sizes = 2.0 * boxes.half_extent.sort(dim=1).values
    return columns_of(_FORMULAS, _Measured(sizes, boxes.volume(), height, area(hull(image)), pixels.double()))
