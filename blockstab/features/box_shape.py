"""What the box of a segment says of it beside Table 1: its sizes, where it ends, how the image fills it."""

from __future__ import annotations

import torch
from torch import Tensor

from blockstab.boxes.box import Boxes
from blockstab.convex import area, hull
from blockstab.rgbd.frame import Camera
from blockstab.rgbd.ground import Ground

BOX_SHAPE_COLUMNS = (
    "size_least",
    "size_middle",
    "size_greatest",
    "volume_log",
    "bottom",
    "top",
    "fill_of_box",
)
_NEAREST = 0.05  # metres from the camera: corners closer, or behind it, count as so far away
_MIN_VOLUME = 1e-6  # cubic metres


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
    covered = area(hull(image))
    columns = [
        *(2.0 * boxes.half_extent.sort(dim=1).values).unbind(dim=1),
        boxes.volume().clamp(min=_MIN_VOLUME).log(),
        height.amin(dim=1),
        height.amax(dim=1),
        pixels.double() / covered.clamp(min=1.0),
    ]
    return torch.stack(columns, dim=1)
