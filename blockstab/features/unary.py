"""The 30 features of a single segment (paper, Table 1, top)."""

from __future__ import annotations

import torch
from torch import Tensor

from blockstab.scene import Scene
from blockstab.stability.area import on_ground
from blockstab.stability.support import tilt

SCALAR_COLUMNS = (
    "orientation",
    "surface_distance_mean",
    "surface_distance_variance",
    "surface_distance_mean_relative",
    "surface_distance_variance_relative",
    "density",
    "visible_share",
    "intersections",
    "stable",
    "stable_alone",
    "overlap",
    "overlap_relative",
    "offset_from_support",
    "offset_from_support_relative",
)
UNARY_COLUMNS = (
    *SCALAR_COLUMNS,
    *(f"offset_from_corner_{k}" for k in range(8)),
    *(f"offset_from_corner_{k}_relative" for k in range(8)),
)

OVERLAP_M = 0.01  # boxes that touch overlap a little by depth noise; deeper than this, they intersect
UNSUPPORTED_M = 1.0  # the distance to a support area that is not there
_MIN_VOLUME = 1e-6  # cubic metres


def unary_features(scene: Scene) -> Tensor:
    """Features of each segment, (N, 30) float64, in the order of `UNARY_COLUMNS`.

    "Relative" values are divided by the volume of the box, as the caption of Table 1 says. Offsets are horizontal
    distances from the centre of mass of the box with all that rests on it; those from its corners are sorted.
    """
    volume = scene.boxes.volume().clamp(min=_MIN_VOLUME)
    orientation = tilt(scene.boxes.rotation.transpose(1, 2)).amin(dim=1)
    count, overlap = intersections(scene)
    mass_center = on_ground(scene.balance.mass_center)
    from_support = (mass_center - scene.balance.support_center).norm(dim=-1).nan_to_num(UNSUPPORTED_M)
    from_support = from_support.clamp(max=UNSUPPORTED_M)
    from_corners = (on_ground(scene.boxes.corners()) - mass_center[:, None]).norm(dim=-1).sort(dim=1).values
    scalars = [
        orientation,
        scene.fit_mean,
        scene.fit_variance,
        scene.fit_mean / volume,
        scene.fit_variance / volume,
        scene.points / volume,
        scene.visible_share,
        count,
        scene.balance.stable,
        scene.balance.stable_alone,
        overlap,
        overlap / volume,
        from_support,
        from_support / volume,
    ]
    columns = torch.stack([column.to(torch.float64) for column in scalars], dim=1)
    return torch.cat([columns, from_corners, from_corners / volume[:, None]], dim=1)


def intersections(scene: Scene) -> tuple[Tensor, Tensor]:
    """How many objects the box of each segment intersects, (N,), and the mean depth of its overlaps, (N,) metres.

    Background takes no part: a box around a table top says nothing about what stands on it.
    """
    pairs, movable = scene.pairs, ~scene.background
    counted = movable[pairs.first] & movable[pairs.second]
    depth = (-pairs.gap[counted]).clamp(min=0.0)
    both = torch.cat([pairs.first[counted], pairs.second[counted]])
    depth = depth.repeat(2)
    zeros = torch.zeros(len(scene), dtype=torch.float64)
    count = zeros.index_add(0, both, (depth > OVERLAP_M).to(torch.float64))
    touching = zeros.index_add(0, both, (depth > 0).to(torch.float64))
    return count, zeros.index_add(0, both, depth) / touching.clamp(min=1.0)
