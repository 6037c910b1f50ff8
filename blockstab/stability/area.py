"""Support areas of one box on another, projected on the ground (paper, section 5.2)."""

from __future__ import annotations

import torch
from torch import Tensor

from blockstab.boxes.box import Boxes
from blockstab.geometry.convex_hulls import Polygons, clip, hull, segments

TIE = 1e-9  # metres by which two edges may differ in distance and still be as near


def on_ground(points: Tensor) -> Tensor:
    """Project points (..., 3) of the world frame on the ground plane: (..., 2), x and z."""
    return points[..., [0, 2]]


def footprints(boxes: Boxes) -> Polygons:
    """The shadows of the boxes on the ground plane."""
    return hull(on_ground(boxes.corners()))


def surface_areas(shadows: Polygons, supporter: Tensor, supported: Tensor) -> Polygons:
    """Areas of "surface on-top" support: where the two footprints overlap. Indices: (E,)."""
    return clip(shadows[supporter], shadows[supported])


def touching_edges(boxes: Boxes, supporter: Tensor, supported: Tensor) -> Polygons:
    """Areas of "partial on-top" and "side" support: the edge of the supported box that touches the other.

    It is the edge whose two ends are nearest to the other box on average, the first of several, a polygon of two
    vertices.
    """
    edges = boxes[supported].edges()  # (E, 12, 2, 3)
    other = boxes[supporter]
    beyond = other.local(edges.flatten(1, 2)).abs() - other.half_extent[:, None]
    outside = beyond.clamp(min=0).norm(dim=-1)
    distance = torch.where(beyond.amax(dim=-1) > 0, outside, beyond.amax(dim=-1))  # negative within the box
    distance = distance.view(-1, 12, 2).mean(dim=-1)
    # Where boxes are parallel several edges are as near; rounding, which differs between processors, must not choose.
    best = (distance <= distance.amin(dim=1, keepdim=True) + TIE).long().argmax(dim=1)
    return segments(on_ground(edges[torch.arange(len(best)), best]))


def lowest_corners(boxes: Boxes, reach: Tensor) -> Polygons:
    """Areas of tilted boxes on the ground: the corners at most `reach` (N,) metres above the lowest one."""
    corners = boxes.corners()
    height = corners[..., 1]
    low = height <= height.amin(dim=1, keepdim=True) + reach[:, None]
    return hull(on_ground(corners), low)
