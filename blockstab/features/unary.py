"""The 30 features of a single segment (paper, Table 1, top)."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import torch
from torch import Tensor

from blockstab.features.formulas import columns_of
from blockstab.scene.types import Scene
from blockstab.stability.area import on_ground
from blockstab.stability.support import tilt

OVERLAP_M = 0.01  # boxes that touch overlap a little by depth noise; deeper than this, they intersect
UNSUPPORTED_M = 1.0  # the distance to a support area that is not there
_MIN_VOLUME = 1e-6  # cubic metres


class _Measured(NamedTuple):
    """Measurements of N segments, each of (N,) but the last; metres and cubic metres."""

    scene: Scene
    volume: Tensor
    orientation: Tensor
    intersections: Tensor
    overlap: Tensor
    from_support: Tensor
    from_corners: Tensor  # (N, 8) ascending


_Formula = Callable[[_Measured], Tensor]


def _corner(k: int) -> _Formula:
    return lambda m: m.from_corners[:, k]


def _corner_relative(k: int) -> _Formula:
    return lambda m: m.from_corners[:, k] / m.volume


_FORMULAS: dict[str, _Formula] = {
    "orientation": lambda m: m.orientation,
    "surface_distance_mean": lambda m: m.scene.fit_mean,
    "surface_distance_variance": lambda m: m.scene.fit_variance,
    "surface_distance_mean_relative": lambda m: m.scene.fit_mean / m.volume,
    "surface_distance_variance_relative": lambda m: m.scene.fit_variance / m.volume,
    "density": lambda m: m.scene.point_count / m.volume,
    "visible_share": lambda m: m.scene.visible_share,
    "intersections": lambda m: m.intersections,
    "stable": lambda m: m.scene.balance.stable,
    "stable_alone": lambda m: m.scene.balance.stable_alone,
    "overlap": lambda m: m.overlap,
    "overlap_relative": lambda m: m.overlap / m.volume,
    "offset_from_support": lambda m: m.from_support,
    "offset_from_support_relative": lambda m: m.from_support / m.volume,
    **{f"offset_from_corner_{k}": _corner(k) for k in range(8)},
    **{f"offset_from_corner_{k}_relative": _corner_relative(k) for k in range(8)},
}
UNARY_COLUMNS = tuple(_FORMULAS)


def unary_features(scene: Scene) -> Tensor:
    """Features of each segment, (N, 30) float64, in the order of `UNARY_COLUMNS`.

    "Relative" values are divided by the volume of the box, as the caption of Table 1 says. Offsets are horizontal
    distances from the centre of mass of the box with all that rests on it; those from its corners are sorted.
    """
    mass_center = on_ground(scene.balance.mass_center)
    from_support = (mass_center - scene.balance.support_center).norm(dim=-1).nan_to_num(UNSUPPORTED_M)
    from_corners = (on_ground(scene.boxes.corners()) - mass_center[:, None]).norm(dim=-1)
    measured = _Measured(
        scene,
        scene.boxes.volume().clamp(min=_MIN_VOLUME),
        tilt(scene.boxes.rotation.transpose(1, 2)).amin(dim=1),
        *intersections(scene),
        from_support.clamp(max=UNSUPPORTED_M),
        from_corners.sort(dim=1).values,
    )
    return columns_of(_FORMULAS, measured)


def intersections(scene: Scene) -> tuple[Tensor, Tensor]:
    """Count of objects that each segment's box intersects, (N,), and mean depth of its overlaps, (N,) metres.

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
