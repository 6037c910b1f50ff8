"""Estimation of the up direction and of the ground height."""

from __future__ import annotations

import math
from dataclasses import dataclass

import torch
import torch.nn.functional as F
from torch import Tensor

from blockstab.rgbd.cloud import Cloud

_LEVEL = (0.0, -1.0, 0.0)  # up, for a camera held level
_DOWNCAST = (0.0, -math.sqrt(0.75), -0.5)  # and for one that looks 30 degrees down
_ROUNDS_DEG = (45.0, 15.0)
_ITERATIONS = 5
_PULL = 1e-3  # of all normals: as many vote for the start, which settles what the others leave open
_NEAR = math.cos(math.radians(15.0))
_ACROSS = math.sin(math.radians(15.0))
_FLAT = 0.95  # cosine to up of the normals that count for the height
_BIN = 0.01  # metres
_GROUND_SHARE = 0.05  # of what faces up, the least that is ground: a chair behind the table is less
_SURFACE_SHARE = 0.01  # of all normals, the least that is a surface
_FEWEST = 100  # normals


@dataclass(frozen=True)
class Ground:
    """The ground plane, as the camera sees it.

    Args:
        up_camera: (3,) float64 unit vector, camera frame.
        world_from_camera: (3, 3) float64 rotation, det +1, that takes `up_camera` to +y.
        height: y of the ground plane in the world frame, metres; None where no horizontal surface was found.
        confidence: between 0 and 1.
    """

    up_camera: Tensor
    world_from_camera: Tensor
    height: float | None
    confidence: float


def estimate_ground(cloud: Cloud) -> Ground:
    """Find up and the ground from the surfaces in view; the cloud is in the camera frame.

    The direction is first the one that most normals are parallel or perpendicular to (Gupta et al. 2013,
    "Perceptual organization and recognition of indoor scenes from RGB-D images"), then the normal of the
    largest horizontal plane. The search starts at a camera held level and reaches tilts of 45 degrees; where
    it meets nothing that faces up, it starts again at one that looks 30 degrees down, and reaches 75.

    The ground is the lowest surface with a twentieth of all points that face up: where the picture shows a
    table top, the table.

    Confidence is the share of normals within 15 degrees of parallel or perpendicular to up, scaled so that
    random normals have 0. It falls in proportion where less than a twentieth of them face up, to 0 where none
    does; and to a quarter where the camera has to look down by more than 45 degrees, because a wall seen by a
    camera that looks up would give the same picture.
    """
    points = cloud.points[::2, ::2].reshape(-1, 3)
    normals = cloud.normals[::2, ::2].reshape(-1, 3)
    known = normals.any(-1)
    points, normals = points[known], normals[known]
    level = cloud.points.new_tensor(_LEVEL)
    if len(normals) < _FEWEST:
        return Ground(level, world_from_camera(level), None, 0.0)

    noise, trust = cloud.noise.deviation, 1.0
    up = _levelled(points, normals, _vote(normals, level), noise)
    if _facing(normals, up) < _SURFACE_SHARE:
        steep = _levelled(points, normals, _vote(normals, cloud.points.new_tensor(_DOWNCAST)), noise)
        if _facing(normals, steep) >= _SURFACE_SHARE:
            up, trust = steep, 0.25
    return Ground(up, world_from_camera(up), _height(cloud, up), trust * _confidence(normals, up))


def ground_from_up(cloud: Cloud, up_camera: Tensor) -> Ground:
    """Find the ground below a known up direction (3,), of any length; the cloud is in the camera frame.

    The height is found as `estimate_ground` finds it; confidence is 1, since the direction is given.
    """
    up = up_camera.to(cloud.points)
    if up.shape != (3,) or not up.isfinite().all() or up.norm() == 0:
        raise ValueError(
            f"up_camera must be three finite numbers that are not all zero, but it is {up_camera.tolist()}; "
            "give the up direction in the camera frame, (0, -1, 0) for a camera held level."
        )
    up = up / up.norm()
    return Ground(up, world_from_camera(up), _height(cloud, up), 1.0)


def world_from_camera(up_camera: Tensor) -> Tensor:
    """(3, 3) rotation, det +1, from the camera frame to the world frame, given the unit up direction (3,).

    Convention:
        World y is up. World x is the camera's x made horizontal, z = x cross y: for a camera held level
        x is x, y is -y, z is -z, so the camera looks along -z. Where the camera's x is nearly vertical, as in
        a portrait picture, -z is the camera's z made horizontal instead.
    """
    right, _, forward = torch.eye(3, dtype=up_camera.dtype, device=up_camera.device)
    if (up_camera @ right).abs() < 0.9:
        x = F.normalize(right - (up_camera @ right) * up_camera, dim=0)
    else:
        x = F.normalize(torch.linalg.cross(forward, up_camera), dim=0)
    return torch.stack([x, up_camera, torch.linalg.cross(x, up_camera)])


def _vote(normals: Tensor, start: Tensor) -> Tensor:
    """(3,) unit direction, near `start`, that most of the (N, 3) normals are parallel or perpendicular to."""
    up = start
    for degrees in _ROUNDS_DEG:
        for _ in range(_ITERATIONS):
            cosine = (normals @ up).abs()
            parallel = normals[cosine > math.cos(math.radians(degrees))]
            across = normals[cosine < math.sin(math.radians(degrees))]
            pull = _PULL * len(normals) * torch.outer(start, start)
            axis = torch.linalg.eigh(across.T @ across - parallel.T @ parallel - pull).eigenvectors[:, 0]
            up = torch.where(axis @ up > 0, axis, -axis)
    return up


def _levelled(points: Tensor, normals: Tensor, up: Tensor, noise: float) -> Tensor:
    """`up` turned to the normal of the largest horizontal plane; as it was where there is no such plane.

    The plane is fitted to inverse depth, which is linear on it and in which the sensor's noise is even.
    """
    flat = normals @ up > _NEAR
    if flat.sum() < max(_FEWEST, _SURFACE_SHARE * len(normals)):
        return up
    heights = points[flat] @ up
    bins = _histogram(heights)
    rays, inverse = points[flat] / points[flat][:, 2:], 1.0 / points[flat][:, 2]
    near = (heights - heights.min() - (bins.argmax() + 0.5) * _BIN).abs() < 2 * _BIN
    for _ in range(_ITERATIONS):
        if near.sum() < _FEWEST:
            return up
        chosen = rays[near]
        # `lstsq` rounds by where its workspace happens to lie in memory: the same image, other bits.
        plane = torch.linalg.pinv(chosen.T @ chosen, hermitian=True) @ (chosen.T @ inverse[near])
        near = (rays @ plane - inverse).abs() < 3 * noise
    fitted = -F.normalize(plane, dim=0)
    return fitted if fitted @ up > _NEAR else up


def _histogram(heights: Tensor) -> Tensor:
    """Counts in bins of a centimetre from the lowest height up, each with its two neighbours."""
    counts = F.pad(torch.bincount(((heights - heights.min()) / _BIN).long()), (1, 1))
    return counts[:-2] + counts[1:-1] + counts[2:]


def _height(cloud: Cloud, up: Tensor) -> float | None:
    """Height along `up` of the lowest surface that faces up, metres; None where none does."""
    known = cloud.normals.any(-1)
    heights = (cloud.points @ up)[known & (cloud.normals @ up > _FLAT)]
    if len(heights) < max(_FEWEST, _SURFACE_SHARE * int(known.sum())):
        return None
    bins = _histogram(heights)
    crest = F.max_pool1d(bins[None].to(heights), 5, stride=1, padding=2)[0] == bins
    surfaces = torch.nonzero(crest & (bins >= _GROUND_SHARE * len(heights)))[:, 0]
    if not len(surfaces):
        return None
    height = heights.min() + (surfaces[0] + 0.5) * _BIN
    for _ in range(_ITERATIONS):
        height = heights[(heights - height).abs() <= 1.5 * _BIN].median()
    return float(height)


def _facing(normals: Tensor, up: Tensor) -> float:
    """Share of the normals that are within 15 degrees of up."""
    return float((normals @ up > _NEAR).double().mean())


def _confidence(normals: Tensor, up: Tensor) -> float:
    """Between 0 and 1; see `estimate_ground`."""
    cosine = (normals @ up).abs()
    explained = float(((cosine > _NEAR) | (cosine < _ACROSS)).double().mean())
    chance = 1.0 - _NEAR + _ACROSS
    return max(0.0, (explained - chance) / (1.0 - chance)) * min(1.0, _facing(normals, up) / 0.05)
