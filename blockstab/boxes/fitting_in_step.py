"""Algorithm 1 on many sets in step, in torch: what the machine code of `MinimumSurface` is held to."""

from __future__ import annotations

import torch
from torch import Tensor

from blockstab.boxes.box import Boxes
from blockstab.boxes.extent import enclose, flat_frame, surface_distance
from blockstab.boxes.fitting import Fits, MinimumSurface, check, judged, masked_mean
from blockstab.boxes.plane_fits import first_plane, fixed_plane, perpendicular_plane, refine


def fit_in_step(
    points: Tensor, count: Tensor, seed: Tensor, settings: MinimumSurface, axis: Tensor | None = None
) -> Fits:
    """The same boxes as `settings(points, count, seed, axis)`, but for rounding."""
    check(points, count)
    origin = masked_mean(points, _present(points, count))
    tolerance = settings.tolerance.at(points)
    points = points - origin[:, None]
    few = min(settings.judged_points, points.shape[1])
    rotation = _choose(
        points[:, :few], count.clamp(max=few), tolerance[:, :few], seed, settings, origin, axis
    )
    present = _present(points, count)
    rotation = refine(rotation, points, present, tolerance, axis)
    center, half = enclose(points, present, rotation[:, None], settings.outlier_share, origin)
    boxes = Boxes(center[:, 0] + origin, rotation, half[:, 0])
    return judged(boxes, points + origin[:, None], present)


def _choose(
    points: Tensor,
    count: Tensor,
    tolerance: Tensor,
    seed: Tensor,
    settings: MinimumSurface,
    away: Tensor,
    axis: Tensor | None,
) -> Tensor:
    """The rotation of the best restart, (N, 3, 3): least sum of distances to the box surface."""
    present = _present(points, count)
    draws = settings.draws(seed, axis is not None)
    if axis is None:
        plane = first_plane(points, present, count, tolerance, draws[..., :3])
    else:
        plane = fixed_plane(points, present, count, tolerance, draws[..., 0], axis)
    second, flat = perpendicular_plane(points, present, tolerance, plane, draws[..., 3:])
    rotation = torch.stack([plane.normal, second, torch.linalg.cross(plane.normal, second)], dim=-1)
    if bool(flat.any()):
        face = flat_frame(points, present, plane, flat, settings.outlier_share)
        rotation = torch.where(flat[..., None, None], face[:, None], rotation)
    center, half = enclose(points, present, rotation, settings.outlier_share, away)
    local = points[:, None] @ rotation - (center[:, :, None] @ rotation)
    distance = surface_distance(local, half[:, :, None])
    best = (distance * present[:, None]).sum(dim=-1).argmin(dim=1)
    return rotation[torch.arange(len(points)), best]


def _present(points: Tensor, count: Tensor) -> Tensor:
    return torch.arange(points.shape[1], device=points.device) < count[:, None]
