"""The Min-vol baseline: the smallest box around all points (paper, section 8.2), from Open3D."""

from __future__ import annotations

from dataclasses import dataclass

import torch
from torch import Tensor

from blockstab.boxes.box import MIN_HALF_EXTENT, Boxes
from blockstab.boxes.fitting import Fits, judged
from blockstab.boxes.plane_fits import plane_basis

_FLAT = 1e-9  # metres; below it Open3D's search sees coplanar points and answers with a box of size zero


@dataclass(frozen=True)
class MinimumVolume:
    """Fits the box of minimum volume. It has no use for a given axis, and refuses one.

    Points that lie in one plane (or on a line) have no minimal box in Open3D, which then returns one of size
    zero; they get the principal axes of their spread instead.
    """

    max_points: int = 2000

    def coarser(self, times: float) -> MinimumVolume:
        """Itself: a smallest box asks for no tolerance."""
        return self

    def __call__(self, points: Tensor, count: Tensor, seed: Tensor, axis: Tensor | None = None) -> Fits:
        """Arguments as in `MinimumSurface`."""
        if axis is not None:
            raise ValueError(
                "Boxes of minimum volume cannot follow an axis; use MinimumSurface with the re-fit."
            )
        if not len(points):
            return Fits.none()
        found = [_one(points[i, : int(n)]) for i, n in enumerate(count)]
        centers, rotations, halves = (torch.stack(column) for column in zip(*found, strict=True))
        boxes = Boxes(centers, rotations, halves.clamp(min=MIN_HALF_EXTENT))
        return judged(boxes, points, torch.arange(points.shape[1]) < count[:, None])


def _one(points: Tensor) -> tuple[Tensor, Tensor, Tensor]:
    import open3d as o3d

    spread = torch.linalg.svdvals(points - points.mean(dim=0))
    if points.shape[0] < 4 or float(spread[2]) < _FLAT:
        return _principal(points)
    cloud = o3d.geometry.PointCloud(o3d.utility.Vector3dVector(points.numpy()))
    found = cloud.get_minimal_oriented_bounding_box(robust=True)
    rotation = torch.tensor(found.R, dtype=torch.float64)
    half = torch.tensor(found.extent, dtype=torch.float64) / 2
    if float(half.amax()) <= 0.0 or not bool(rotation.isfinite().all()):
        return _principal(points)
    rotation = rotation * torch.linalg.det(rotation).sign()
    return torch.tensor(found.center, dtype=torch.float64), rotation, half


def _principal(points: Tensor) -> tuple[Tensor, Tensor, Tensor]:
    mean = points.mean(dim=0)
    covariance = (points - mean).T @ (points - mean)
    normal = torch.linalg.eigh(covariance).eigenvectors[:, 0]
    u, v = plane_basis(normal)
    angle = torch.linalg.eigh(torch.stack([u, v]) @ covariance @ torch.stack([u, v]).T).eigenvectors[:, 1]
    long = angle[0] * u + angle[1] * v
    rotation = torch.stack([normal, long, torch.linalg.cross(normal, long)], dim=1)
    local = (points - mean) @ rotation
    low, high = local.amin(dim=0), local.amax(dim=0)
    return mean + rotation @ ((low + high) / 2), rotation, (high - low) / 2
