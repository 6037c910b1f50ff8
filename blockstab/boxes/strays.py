"""Stray points of a segment: few, and far from all others, as where colour and depth slip against each other."""

from __future__ import annotations

import torch
from torch import Tensor

from blockstab.boxes.box import MIN_HALF_EXTENT, Boxes

STRAY_SHARE = 0.2  # of the points at most lie beyond a gap
GAP_M = 0.02  # between them and the others, along an axis of the box


def without_strays(boxes: Boxes, points: Tensor, count: Tensor) -> Boxes:
    """The boxes, cut where beyond a gap there are only strays; a face without strays stays where it is.

    Args:
        boxes: N boxes, fitted to their points.
        points: (N, P, 3) in the same frame; count: (N,) how many of them are real, the first ones.
    """
    n, most = points.shape[:2]
    real = torch.arange(most) < count[:, None]
    along = boxes.local(points).masked_fill(~real[..., None], torch.inf).sort(dim=1).values
    wide = along.diff(dim=1) >= GAP_M  # (N, P - 1, 3)
    beneath = (torch.arange(1, most)[:, None] * torch.ones(3, dtype=torch.int64)).expand(n, -1, -1)
    above, allowed = count[:, None, None] - beneath, STRAY_SHARE * count[:, None, None]
    low_cut = torch.where(wide & (beneath <= allowed) & (above > 0), beneath, 0).amax(dim=1)
    high_cut = torch.where(wide & (above <= allowed) & (above > 0), above, 0).amax(dim=1)
    low = along.gather(1, low_cut[:, None])[:, 0]
    high = along.gather(1, (count[:, None] - 1 - high_cut)[:, None])[:, 0]
    low = torch.where(low_cut > 0, low, -boxes.half_extent)
    high = torch.where(high_cut > 0, high, boxes.half_extent)
    middle, half = (low + high) / 2, ((high - low) / 2).clamp(min=MIN_HALF_EXTENT)
    cut = ((low_cut > 0) | (high_cut > 0)).any(dim=1, keepdim=True)
    center = boxes.center + (boxes.rotation @ middle[..., None])[..., 0]
    return Boxes(
        torch.where(cut, center, boxes.center), boxes.rotation, torch.where(cut, half, boxes.half_extent)
    )
