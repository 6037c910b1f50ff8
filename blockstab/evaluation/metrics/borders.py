"""Borders of the regions of a label image."""

from __future__ import annotations

from collections.abc import Sequence

import torch
from torch import Tensor
from torch.nn.functional import pad


def outlines(label: Tensor) -> Tensor:
    """The outline of every region, one pixel wide.

    A pixel is on the outline of a region if one, but not all, of the pixel and its neighbours to the right, below
    and below right are in the region: outlines lie half a pixel up and left of where regions meet. This is the
    outline of the DAVIS benchmark (Perazzi et al. 2016), which Xie et al. (2020) score unseen objects with.

    Args:
        label: (H, W) int64, 0 = none.

    Returns:
        (N, 3) int64 label, row, column; a pixel comes once for each region whose outline it is on.
    """
    padded = pad(label[None].double(), (0, 1, 0, 1), mode="replicate")[0].to(label.dtype)
    corners = torch.stack([padded[:-1, :-1], padded[:-1, 1:], padded[1:, :-1], padded[1:, 1:]], dim=2)
    place = (corners != corners[..., :1]).any(dim=2).nonzero()
    ids = corners[place[:, 0], place[:, 1]].sort(dim=1).values  # (M, 4)
    first = torch.ones_like(ids, dtype=torch.bool)
    first[:, 1:] = ids[:, 1:] != ids[:, :-1]
    at, which = (first & (ids > 0)).nonzero(as_tuple=True)
    return torch.cat([ids[at, which, None], place[at]], dim=1)


def inner_border(label: Tensor, regions: Sequence[int]) -> Tensor:
    """Pixels of some regions with a pixel of any other region right beside, above or below them.

    Args:
        label: (H, W) int64, 0 = none.
        regions: ids of the regions whose border is meant, as those of the objects.

    Returns:
        (H, W) bool. The rim of the image is no border.
    """
    return borders(label) & torch.isin(label, torch.tensor(regions, dtype=label.dtype, device=label.device))


def borders(label: Tensor) -> Tensor:
    """(H, W) bool: pixels with another label right beside, above or below them."""
    border = torch.zeros_like(label, dtype=torch.bool)
    across, down = label[:, 1:] != label[:, :-1], label[1:] != label[:-1]
    border[:, 1:] |= across
    border[:, :-1] |= across
    border[1:] |= down
    border[:-1] |= down
    return border


def near(points: Tensor, others: Tensor, tolerance_px: float) -> Tensor:
    """Mask of the points that have one of the others within a distance.

    Args:
        points: (N, D); others: (M, D), coordinates in pixels.
        tolerance_px: the distance, itself included.

    Returns:
        (N,) bool.
    """
    from scipy.spatial import cKDTree

    if not len(points) or not len(others):
        return torch.zeros(len(points), dtype=torch.bool, device=points.device)
    distance, _ = cKDTree(others.cpu().numpy()).query(points.cpu().numpy())
    return torch.from_numpy(distance <= tolerance_px).to(points.device)
