"""Contrast of two regions: the 46 appearance features that do not depend on the course of their border."""

from __future__ import annotations

from typing import Literal

import torch
from torch import Tensor

from blockstab.features.appearance.extents import residuals
from blockstab.features.appearance.regions import Regions

Variant = Literal["fixed", "released"]

_STATISTICS = ("mean", "median", "greatest")
CONTRAST_COLUMNS = (
    "area_smaller",
    "area_larger",
    "color_mean_interior",
    "color_deviation_interior",
    "color_mean_border",
    "color_deviation_border",
    "value_deviation_interior",
    "value_deviation_border",
    "volume_overlap",
    "density",
    "volume_ratio",
    "gap",
    "centroid_distance",
    "footprint_overlap",
    "footprint_gap",
    "footprint_distance",
    "near_residual",
    "normal",
    "horizontal",
    "vertical",
    "wall_1",
    "wall_2",
    "wall",
    "vertical_no_wall",
    "slanted",
    "class_total",
    "planes",
    *(f"residual_{which}" for which in _STATISTICS),
    *(f"other_residual_{which}" for which in _STATISTICS),
    "lowest",
    "highest",
    "slenderness_greatest",
    "slenderness_least",
    *(f"inclination_{quarter}" for quarter in range(4)),
    *(f"azimuth_{quarter}" for quarter in range(4)),
    "angle_total",
)
_MIN_SIZE = 1e-9  # square or cubic metres


def contrast(regions: Regions, first: Tensor, second: Tensor, variant: Variant) -> Tensor:
    """Features of any two regions, (P, 46) float64, in the order of `CONTRAST_COLUMNS`.

    Args:
        first, second: (P,) indices into `regions`; either order gives the same.
    """
    released = variant == "released"
    colors = _colors(regions, first, second)
    positions = _positions(regions, first, second, released)
    facing = regions.facing[:, 1 if released else 0]
    apart = (facing[first] - facing[second]).abs()
    normal, classes, angles = apart[:, :3], apart[:, 3:10], apart[:, 10:]
    others = _residuals_to(regions, first, second) + _residuals_to(regions, second, first)
    class_total, angle_total = classes.sum(dim=1), angles.sum(dim=1)
    if released:
        colors = colors[:, [0, 1, 2, 3, 4, 3, 6, 7]]
        others = others[:, [0, 1, 1]]
        class_total, angle_total = positions[:, 1:].sum(dim=1), 2 * angles[:, :4].sum(dim=1)
    return torch.cat(
        [
            colors,
            positions,
            _near_residual(regions, first, second)[:, None],
            normal.sum(dim=1, keepdim=True),
            classes,
            class_total[:, None],
            (regions.planes[first] - regions.planes[second]).abs().sum(dim=1, keepdim=True),
            (regions.shapes.residual[first] - regions.shapes.residual[second]).square(),
            others,
            _heights(regions, first, second),
            angles,
            angle_total[:, None],
        ],
        dim=1,
    )


def _colors(regions: Regions, first: Tensor, second: Tensor) -> Tensor:
    """(P, 8)."""
    colors = regions.colors
    share = torch.stack([regions.share[first], regions.share[second]])
    mean = (colors.mean[first] - colors.mean[second]).norm(dim=-1)
    deviation = (colors.deviation[first] - colors.deviation[second]).norm(dim=-1)
    value = (colors.value_deviation[first] - colors.value_deviation[second]).abs()
    by_part = torch.stack([mean, deviation], dim=2).flatten(1)
    return torch.cat([share.amin(dim=0)[:, None], share.amax(dim=0)[:, None], by_part, value], dim=1)


def _positions(regions: Regions, first: Tensor, second: Tensor, released: bool) -> Tensor:
    """(P, 8)."""
    places, shapes = regions.places, regions.shapes
    upper = torch.minimum(places.greatest[first], places.greatest[second])
    lower = torch.maximum(places.least[first], places.least[second])
    shared, apart = (upper - lower).clamp(min=0.0), (lower - upper).clamp(min=0.0)
    if released:
        apart = apart * apart.new_tensor([1.0, 1.0, 0.0])
    size = places.greatest - places.least
    box, ground = size.prod(dim=1), size[:, 0] * size[:, 2]
    away = places.mean[first] - places.mean[second]
    volume = torch.stack([shapes.volume[first], shapes.volume[second]])
    columns = [
        shared.prod(dim=1) / torch.minimum(box[first], box[second]).clamp(min=_MIN_SIZE),
        (shapes.density[first] - shapes.density[second]).abs(),
        volume.amax(dim=0) / volume.amin(dim=0),
        apart.norm(dim=1),
        away.norm(dim=1),
        shared[:, 0] * shared[:, 2] / torch.minimum(ground[first], ground[second]).clamp(min=_MIN_SIZE),
        apart[:, [0, 2]].norm(dim=1),
        away[:, [0, 2]].norm(dim=1),
    ]
    return torch.stack(columns, dim=1)


def _near_residual(regions: Regions, first: Tensor, second: Tensor) -> Tensor:
    """(P,) mean distance of five points of each to the plane of the other, relative to how near they are."""
    total = torch.zeros(len(first), dtype=torch.float64)
    for here, there in ((first, second), (second, first)):
        plane = regions.places.plane[there]
        away = (regions.places.few[here] @ plane[:, :3, None])[..., 0] + plane[:, 3:]
        total = total + away.abs().mean(dim=1) / regions.places.near[here]
    return total


def _residuals_to(regions: Regions, here: Tensor, there: Tensor) -> Tensor:
    """(P, 3)."""
    shapes = regions.shapes
    return residuals(shapes.samples[here], shapes.sampled[here], shapes.plane[there])


def _heights(regions: Regions, first: Tensor, second: Tensor) -> Tensor:
    """(P, 4)."""
    shapes = regions.shapes
    rise = torch.stack([shapes.rise[first], shapes.rise[second]])
    slender = shapes.height / shapes.base
    slenderness = torch.stack([slender[first], slender[second]])
    columns = [
        rise[..., 0].amin(dim=0),
        rise[..., 1].amax(dim=0),
        slenderness.amax(dim=0),
        slenderness.amin(dim=0),
    ]
    return torch.stack(columns, dim=1)
