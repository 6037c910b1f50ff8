"""Extents of boxes of given axes that hold their points (paper, section 4.1)."""

from __future__ import annotations

import torch
from torch import Tensor

from blockstab.boxes.box import MIN_HALF_EXTENT
from blockstab.boxes.plane_fits import Plane, plane_basis

_COARSE_DEG, _FINE_DEG = 3.0, 0.25


def _directions(angle_deg: Tensor) -> Tensor:
    angle = torch.deg2rad(angle_deg)
    return torch.stack([torch.cos(angle), torch.sin(angle)], dim=-1)


# Tables, because torch rounds sines by the place of a number in the batch.
COARSE = _directions(torch.arange(0.0, 90.0, _COARSE_DEG, dtype=torch.float64))
FINE = _directions(torch.arange(-_COARSE_DEG, _COARSE_DEG + 1e-9, _FINE_DEG, dtype=torch.float64))


def enclose(
    points: Tensor, present: Tensor, rotation: Tensor, outlier_share: float, away: Tensor
) -> tuple[Tensor, Tensor]:
    """Reach along each axis so that at most `outlier_share` of the points stay outside.

    Each of the six faces may leave out a sixth of that share, so that the union of what is left out keeps
    the bound jointly. A box thinner than `MIN_HALF_EXTENT` is thickened away from the camera: what was seen is
    its near face.

    Args:
        points: (N, P, 3); present: (N, P); rotation: (N, R, 3, 3), columns are axes.
        away: (N, 3) from the camera to the points.

    Returns:
        centers (N, R, 3) in the frame of the points, and half extents (N, R, 3), both metres.
    """
    local = (points[:, None] @ rotation).transpose(2, 3)  # (N, R, 3, P)
    rank = (outlier_share / 6 * present.sum(dim=1)).long()
    low = _lowest(local, present, rank)
    high = -_lowest(-local, present, rank)
    half, middle = (high - low) / 2, (high + low) / 2
    solid = half.clamp(min=MIN_HALF_EXTENT)
    outward = (away[:, None, None] @ rotation)[..., 0, :].sign()  # of each axis, (N, R, 3)
    center = (rotation @ (middle + outward * (solid - half))[..., None])[..., 0]
    return center, solid


def surface_distance(local: Tensor, half_extent: Tensor) -> Tensor:
    """Distance of points to the surface of their box, metres (the paper's D_min).

    Inside it is the distance to the nearest face; outside, the distance to the box.

    Args:
        local: (..., 3) coordinates along the box axes from its centre; half_extent: broadcastable (..., 3).
    """
    beyond = local.abs() - half_extent
    inside = -beyond.amax(dim=-1)
    return torch.where(inside >= 0, inside, beyond.clamp(min=0).norm(dim=-1))


def flat_frame(points: Tensor, present: Tensor, plane: Plane, flat: Tensor, outlier_share: float) -> Tensor:
    """Axes for segments that are one flat face: its normal, and the sides of the smallest rectangle around it.

    Args:
        points: (N, J, 3); present: (N, J); plane: R planes for each set, of which those marked in `flat` (N, R)
            explain nearly all points; the first such plane is used.

    Returns:
        (N, 3, 3) rotations; meaningless for a set without a flat plane.
    """
    normal = plane.normal[torch.arange(points.shape[0]), flat.long().argmax(dim=1)]
    u, v = plane_basis(normal)
    seen = (points[:, None] * torch.stack([u, v], dim=1)[:, :, None]).sum(dim=-1)  # (N, 2, J)
    rank = (outlier_share / 4 * present.sum(dim=1)).long()
    best = _smallest(seen, present, rank, COARSE.expand(points.shape[0], -1, -1))
    cos, sin = best[:, None].unbind(dim=-1)
    turned = [cos * FINE[:, 0] - sin * FINE[:, 1], sin * FINE[:, 0] + cos * FINE[:, 1]]
    best = _smallest(seen, present, rank, torch.stack(turned, dim=-1))
    side = best[:, :1] * u + best[:, 1:] * v
    return torch.stack([normal, side, torch.linalg.cross(normal, side)], dim=-1)


def _smallest(seen: Tensor, present: Tensor, rank: Tensor, along: Tensor) -> Tensor:
    """Of the directions (N, K, 2), the one of the least rectangle around the points (N, 2, J), (N, 2)."""
    cos, sin = along.unbind(dim=-1)
    turned = torch.stack([along, torch.stack([-sin, cos], dim=-1)], dim=2) @ seen[:, None]
    sides = -_lowest(-turned, present, rank) - _lowest(turned, present, rank)  # (N, K, 2)
    return along[torch.arange(len(along)), sides.prod(dim=-1).argmin(dim=1)]


def _lowest(values: Tensor, present: Tensor, rank: Tensor) -> Tensor:
    """The value of each rank among those present: (N, R, D, P), (N, P), (N,) to (N, R, D)."""
    ordered = values.masked_fill(~present[:, None, None], float("inf"))
    lowest = ordered.topk(int(rank.max()) + 1, dim=-1, largest=False).values
    return lowest.gather(-1, rank[:, None, None, None].expand(-1, *values.shape[1:3], 1))[..., 0]
