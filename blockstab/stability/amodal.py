"""Amodal extension of boxes: how far down one may reach where the camera could not look.

The paper takes all supports to be visible. Behind another object a box shows only its upper part; fitted to that,
it would float. What nothing stands under, and whose lower part is hidden, is taken to go on to what lies beneath.
"""

from __future__ import annotations

from collections.abc import Callable

import torch
from torch import Tensor

from blockstab.boxes.box import Boxes
from blockstab.geometry.convex_hulls import area, clip
from blockstab.stability.area import footprints

HIDDEN_SHARE = 0.8  # of what would be seen of a part that is added must be hidden
_MIN_OVERLAP = 0.1  # share of its footprint that must lie over a thing for the thing to carry it
_GRID = 6  # points along either direction of a side face
_UPRIGHT = 0.94  # cosine of 20 degrees: a tilted box has no side that goes straight down


def extended_down(
    boxes: Boxes,
    floating: Tensor,
    pairs: tuple[Tensor, Tensor],
    ground_height: Tensor,
    hidden: Callable[[Tensor], Tensor],
) -> Boxes:
    """Lengthen floating boxes down to the highest thing beneath them, or to the ground, where that is hidden.

    Args:
        boxes: N boxes in the world frame.
        floating: (N,) bool; the others stay as they are.
        pairs: (P,) and (P,) indices of boxes that may stand on each other.
        ground_height: (N,) metres.
        hidden: tells of points (..., 3) whether the camera could not see them.
    """
    which = floating.nonzero()[:, 0]
    vertical = boxes.rotation[:, 1].abs().argmax(dim=1)
    which = which[boxes.rotation[which, 1, vertical[which]].abs() > _UPRIGHT]
    if not len(which):
        return boxes
    corners = boxes.corners()
    bottom = corners[..., 1].amin(dim=1)
    floor = _floor_under(boxes, corners, bottom, pairs, ground_height)
    drop = (bottom - floor)[which]
    longer = _lengthened(boxes[which], vertical[which], drop)
    sides, facing = _lower_sides(longer, vertical[which], drop)
    unseen = (hidden(sides) & facing[..., None]).sum(dim=(1, 2)) / (facing.sum(dim=1) * _GRID**2).clamp(min=1)
    grown = which[(unseen >= HIDDEN_SHARE) & (drop > 0)]
    center, half = boxes.center.clone(), boxes.half_extent.clone()
    place = torch.isin(which, grown)
    center[grown], half[grown] = longer.center[place], longer.half_extent[place]
    return Boxes(center, boxes.rotation, half)


def _floor_under(
    boxes: Boxes, corners: Tensor, bottom: Tensor, pairs: tuple[Tensor, Tensor], ground_height: Tensor
) -> Tensor:
    """(N,) height of the highest thing under each box, the ground where there is nothing else."""
    upper, lower = torch.cat(pairs), torch.cat(pairs[::-1])
    top = corners[..., 1].amax(dim=1)
    beneath = top[lower] < bottom[upper]
    upper, lower = upper[beneath], lower[beneath]
    shadows = footprints(boxes)
    shared = area(clip(shadows[upper], shadows[lower])) > _MIN_OVERLAP * area(shadows)[upper]
    return ground_height.scatter_reduce(0, upper[shared], top[lower[shared]], "amax")


def _lengthened(boxes: Boxes, vertical: Tensor, drop: Tensor) -> Boxes:
    """The boxes with their lower face moved down by `drop` (K,) along their most vertical axis."""
    n = torch.arange(len(boxes))
    axis = boxes.rotation[n, :, vertical]
    downward = -axis * torch.where(axis[:, 1:2] < 0, -1.0, 1.0)
    length = drop.clamp(min=0.0) / downward[:, 1].abs()
    half = boxes.half_extent.clone()
    half[n, vertical] += length / 2
    return Boxes(boxes.center + downward * (length / 2)[:, None], boxes.rotation, half)


def _lower_sides(boxes: Boxes, vertical: Tensor, drop: Tensor) -> tuple[Tensor, Tensor]:
    """Points (K, 4, G * G, 3) on the lowest `drop` metres of the sides, and which sides face the camera (K, 4)."""
    n = torch.arange(len(boxes))
    steps = (torch.arange(_GRID, dtype=boxes.center.dtype) + 0.5) / _GRID
    across, up = torch.meshgrid(2 * steps - 1, steps, indexing="ij")
    axis = boxes.rotation[n, :, vertical]
    upward = axis * torch.where(axis[:, 1:2] < 0, -1.0, 1.0)
    base = boxes.center - upward * boxes.half_extent[n, vertical][:, None]
    points, facing = [], []
    for turn in (1, 2):
        out, along = (vertical + turn) % 3, (vertical + 3 - turn) % 3
        out_axis = boxes.rotation[n, :, out] * boxes.half_extent[n, out][:, None]
        along_axis = boxes.rotation[n, :, along] * boxes.half_extent[n, along][:, None]
        for sign in (1.0, -1.0):
            face = base + sign * out_axis
            points.append(
                face[:, None]
                + across.flatten()[:, None] * along_axis[:, None]
                + up.flatten()[:, None] * (upward * drop[:, None])[:, None]
            )
            facing.append((sign * out_axis * face).sum(dim=-1) < 0)
    return torch.stack(points, dim=1), torch.stack(facing, dim=1)
