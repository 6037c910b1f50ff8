"""Planes and upright boxes of few points each, for many regions at once."""

from __future__ import annotations

import math

import numpy as np
import torch
import torch.nn.functional as F
from torch import Tensor

_ANGLES = 10  # rectangles tried around each footprint; they repeat after 90 degrees
_FRONTAL = 1e-10  # square metres: what decides where points fix no plane
_SHORTEST = 1e-3  # a normal: the plane that fits best lies at infinity


def kept_samples(points: Tensor, count: Tensor, share: float) -> tuple[Tensor, Tensor]:
    """Without the points that lie farthest from the mean.

    Args:
        points: (R, S, 3), of which each region has the first `count` (R,), at least one.
        share: of its points that each keeps, rounded up.

    Returns:
        (R, S', 3) points, those past the count zero, and (R,) the new count.
    """
    mean = (points * among(count, points.shape[1])[..., None]).sum(dim=1) / count[:, None]
    away = (points - mean[:, None]).square().sum(dim=-1)
    order = torch.where(among(count, points.shape[1]), away, torch.inf).argsort(dim=1, stable=True)
    left = (share * count).ceil().long()
    most = math.ceil(share * points.shape[1])
    nearest = points.gather(1, order[:, :most, None].expand(-1, -1, 3))
    return torch.where(among(left, most)[..., None], nearest, 0.0), left


def among(count: Tensor, most: int) -> Tensor:
    """(R, most) bool: which columns are below the count (R,)."""
    return torch.arange(most) < count[:, None]


def sample_planes(points: Tensor, count: Tensor) -> Tensor:
    """Least-squares planes through the mean of points, (R, 4): unit normal n and d with n . p + d = 0.

    Args:
        points, count: as `kept_samples` returns them.
    """
    inside = among(count, points.shape[1])[..., None]
    mean = points.sum(dim=1) / count[:, None]
    centred = torch.where(inside, points - mean[:, None], 0.0)
    spread = centred.mT @ centred / count[:, None, None]
    normal = torch.linalg.eigh(spread + _facing(mean)).eigenvectors[..., 0]
    return torch.cat([normal, -(normal * mean).sum(dim=1, keepdim=True)], dim=1)


def moment_planes(moments: Tensor) -> Tensor:
    """Planes (R, 4) that fit best in homogeneous coordinates, the normal then made a unit vector.

    Args:
        moments: (R, 4, 4), the mean of (x, y, z, 1) times its transpose.
    """
    facing = F.pad(_facing(moments[:, :3, 3]), (0, 1, 0, 1))
    plane: Tensor = torch.linalg.eigh(moments + facing).eigenvectors[..., 0]
    length: Tensor = plane[:, :3].norm(dim=1, keepdim=True)
    return plane / length.clamp(min=_SHORTEST)


def residuals(points: Tensor, count: Tensor, planes: Tensor) -> Tensor:
    """Mean, median and greatest distance of points to a plane, (R, 3) metres.

    Args:
        points: (R, S, 3), of which each region has the first `count` (R,), at least one; planes: (R, 4).
    """
    away = ((points @ planes[:, :3, None])[..., 0] + planes[:, 3:]).abs()
    inside = among(count, points.shape[1])
    ranked = torch.where(inside, away, torch.inf).sort(dim=1).values
    middle = ranked.gather(1, torch.stack([(count - 1) // 2, count // 2], dim=1)).mean(dim=1)
    away = torch.where(inside, away, 0.0)
    return torch.stack([away.sum(dim=1) / count, middle, away.amax(dim=1)], dim=1)


def footprint_area(points: Tensor, count: Tensor) -> Tensor:
    """Area (R,) of the smallest of ten rectangles around points seen from above, square metres.

    They are turned by multiples of 9 degrees from the points' first principal axis.
    """
    inside = among(count, points.shape[1])
    flat = points[..., [0, 2]]
    centred = torch.where(inside[..., None], flat - flat.sum(dim=1, keepdim=True) / count[:, None, None], 0.0)
    (xx, xz), (_, zz) = (centred.mT @ centred).permute(1, 2, 0)
    step = math.pi / 2 / _ANGLES
    # Not torch's arctangent: it rounds a number differently at the end of a list than in the middle.
    principal = torch.from_numpy(0.5 * np.arctan2((2 * xz).numpy(), (xx - zz).numpy()))
    angle = principal[:, None] + step * torch.arange(_ANGLES)
    axes = torch.stack([torch.stack([angle.cos(), angle.sin()]), torch.stack([-angle.sin(), angle.cos()])])
    along = torch.einsum("rsc,ecra->rsea", centred, axes)
    outside = ~inside[:, :, None, None]
    length = along.masked_fill(outside, -torch.inf).amax(dim=1) - along.masked_fill(outside, torch.inf).amin(
        dim=1
    )
    return length.prod(dim=1).amin(dim=1)


def _facing(mean: Tensor) -> Tensor:
    """(R, 3, 3) so little spread across the line of sight to `mean` that it counts only where there is no other."""
    sight = F.normalize(mean, dim=1)
    return _FRONTAL * (torch.eye(3, dtype=mean.dtype) - sight[:, :, None] * sight[:, None, :])
