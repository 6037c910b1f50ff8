"""Pixel data for the appearance features: a point in the room, colours, the facing of the surface."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import torch
import torch.nn.functional as F
from kornia.color import rgb_to_ycbcr
from scipy.ndimage import distance_transform_edt
from torch import Tensor

from blockstab.boxes.sampling import scramble
from blockstab.observation import Observation
from blockstab.rgbd.cloud import Cloud

FACINGS = (5, 4, 4)

_ALONG = 0.95  # cosine to an axis of a normal that counts as parallel to it
_BINS = 90  # of a degree, for the direction of walls
_NEAR_PEAK_DEG = 5.0


@dataclass(frozen=True)
class Views:
    """Flat images of M = H W pixels, in the order of rows.

    Args:
        order: (M,) int64, all pixels in a fixed random order; the first ones of a region are a random sample.
        points: (M, 3) float64, metres: y up, x and z along the walls. Where no depth was measured, that of the
            nearest pixel where it was.
        depth: (M,) float64, metres, likewise.
        measured: (M,) bool.
        colors: (M, 4) float64: Y, Cb, Cr and the value of HSV, 0 to 1.
        normals: (M, 2, 3) float64, the size of the normal's components: in the room, and as the authors' program
            has them.
        has_normal: (M,) bool, where there is a normal.
        facing: (M, 2) int64, likewise, where it points: an index into a table of `FACINGS`, that is of the kind of
            surface (horizontal, wall facing along x, along z, other vertical, slanted); the quarter of [0, 180]
            degrees from up; and the quarter of the circle about it, the first being centred on the x axis.
        plane: (M,) int64, label of the plane, 0 = none.
        lowest: the least y of all measured points.
    """

    order: Tensor
    points: Tensor
    depth: Tensor
    measured: Tensor
    colors: Tensor
    normals: Tensor
    has_normal: Tensor
    facing: Tensor
    plane: Tensor
    lowest: float


def view(observation: Observation) -> Views:
    """Prepare the pixels of an image."""
    cloud = observation.cloud
    turn = to_room(cloud)
    normals = cloud.normals.flatten(0, 1)
    nearest = _nearest_measured(cloud.valid)
    points = (cloud.points.flatten(0, 1) @ turn.T)[nearest]
    rgb = observation.frame.color.flatten(0, 1).to(torch.float64) / 255.0
    ycbcr = rgb_to_ycbcr(rgb.T[:, :, None])[..., 0].T
    both = torch.stack([normals @ turn.T, _as_released(observation, points)], dim=1)
    valid = cloud.valid.flatten()
    return Views(
        order=scramble(torch.arange(len(points))).argsort(),
        points=points,
        depth=cloud.depth.flatten()[nearest],
        measured=valid,
        colors=torch.cat([ycbcr, rgb.amax(dim=1, keepdim=True)], dim=1),
        normals=both.abs(),
        has_normal=valid & normals.any(dim=1),
        facing=_facing(both),
        plane=observation.planes.label.flatten(),
        lowest=float(points[valid, 1].amin()) if bool(valid.any()) else 0.0,
    )


def to_room(cloud: Cloud) -> Tensor:
    """(3, 3) rotation about y that takes most walls to face along x or z; the cloud is in the world frame.

    The way that vertical surfaces face, modulo 90 degrees, has its peak in a histogram; the walls are the mean of
    what lies within 5 degrees of it. Where nothing is vertical, the rotation is the identity.
    """
    normals = cloud.normals[cloud.valid]
    walls = normals[_vertical(normals)]
    if not len(walls):
        return torch.eye(3, dtype=torch.float64)
    degrees = torch.rad2deg(torch.atan2(walls[:, 2], walls[:, 0])) % 90.0
    votes = torch.bincount(degrees.long().clamp(max=_BINS - 1), minlength=_BINS).double()
    smooth = F.pad(votes[None], (2, 2), mode="circular")[0].unfold(0, 5, 1).sum(dim=1)
    peak = float(smooth.argmax()) + 0.5
    away = (degrees - peak + 45.0) % 90.0 - 45.0
    angle = math.radians(peak + float(away[away.abs() < _NEAR_PEAK_DEG].mean()))
    cos, sin = math.cos(angle), math.sin(angle)
    return torch.tensor([[cos, 0.0, sin], [0.0, 1.0, 0.0], [-sin, 0.0, cos]], dtype=torch.float64)


def _vertical(normals: Tensor) -> Tensor:
    return normals[..., 0].square() + normals[..., 2].square() > _ALONG**2


def _facing(normals: Tensor) -> Tensor:
    """(...,) int64 index into a table of `FACINGS`, for (..., 3) normals."""
    x, y, z = normals.unbind(dim=-1)
    upright = torch.where(z.abs() > _ALONG, 2, torch.where(x.abs() > _ALONG, 1, 3))
    surface = torch.where(y.abs() > _ALONG, 0, torch.where(_vertical(normals), upright, 4))
    inclination = (torch.acos(y.clamp(-1.0, 1.0)) / (math.pi / FACINGS[1])).long().clamp(max=FACINGS[1] - 1)
    azimuth = (torch.atan2(z, x) / (2 * math.pi / FACINGS[2])).round().long() % FACINGS[2]
    return (surface * FACINGS[1] + inclination) * FACINGS[2] + azimuth


def _as_released(observation: Observation, points: Tensor) -> Tensor:
    """(M, 3) normals as the authors' program has them: not turned with the room, yet flipped by points that are."""
    held_level = observation.ground.world_from_camera.new_tensor([1.0, -1.0, -1.0])
    normals = (observation.cloud.normals.flatten(0, 1) @ observation.ground.world_from_camera) * held_level
    return torch.where((normals * points).sum(dim=1, keepdim=True) > 0, -normals, normals)


def _nearest_measured(valid: Tensor) -> Tensor:
    """(M,) int64: for each pixel of the (H, W) mask the nearest where it holds; itself where it holds nowhere."""
    if not bool(valid.any()):
        return torch.arange(valid.numel())
    rows, columns = distance_transform_edt(~valid.numpy(), return_distances=False, return_indices=True)
    return torch.from_numpy(np.asarray(rows * valid.shape[1] + columns, dtype=np.int64).ravel())
