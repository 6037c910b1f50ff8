"""Places of regions, and the shape of what they show."""

from __future__ import annotations

from dataclasses import dataclass

import torch
from torch import Tensor

from blockstab.features.appearance.cells import MOMENT, Cells
from blockstab.features.appearance.extents import (
    footprint_area,
    kept_samples,
    moment_planes,
    residuals,
    sample_planes,
)
from blockstab.features.appearance.grouping import extreme, summed
from blockstab.features.appearance.views import Views

_SAMPLES = 100
_KEPT = 0.9  # of the samples: those nearest to their mean
_FEW = 5
_MIN_VOLUME, _MIN_AREA = 1e-6, 1e-4  # cubic and square metres
_MIN_DEPTH = 1e-3  # metres


@dataclass(frozen=True)
class Places:
    """Statistics of all pixels of R regions, metres.

    Args:
        least, mean, greatest: (R, 3), of the points.
        plane: (R, 4) unit normal and offset, fitted to the points.
        near: (R,) least depth.
        few: (R, 5, 3) random points.
    """

    least: Tensor
    mean: Tensor
    greatest: Tensor
    plane: Tensor
    near: Tensor
    few: Tensor


@dataclass(frozen=True)
class Shapes:
    """Statistics of samples of R regions, metres: up to 100 pixels, less the tenth farthest from their mean.

    Args:
        samples: (R, 90, 3), of which a region has the first `sampled` (R,).
        plane: (R, 4) unit normal and offset, fitted to the samples.
        residual: (R, 3) mean, median and greatest distance of the samples to it.
        volume, base, height: (R,) of the upright box around the samples.
        density: (R,) pixels of the interior by volume.
        rise: (R, 2) of the lowest and highest sample above the lowest point of the image.
    """

    samples: Tensor
    sampled: Tensor
    plane: Tensor
    residual: Tensor
    volume: Tensor
    base: Tensor
    height: Tensor
    density: Tensor
    rise: Tensor


def places(views: Views, cells: Cells, cell: Tensor, region: Tensor, count: int) -> Places:
    """Measure regions 0 to `count` - 1; all arguments as `regions.measured_regions` takes them."""
    moments = summed(cells.moments[cell], region, count)
    moments = (moments / moments[:, 9:])[:, MOMENT]
    least = extreme(cells.least[cell], region, count, "amin")
    return Places(
        least=least[:, :3],
        mean=moments[:, 3, :3],
        greatest=extreme(cells.greatest[cell], region, count, "amax")[:, :3],
        plane=moment_planes(moments),
        near=least[:, 3].clamp(min=_MIN_DEPTH),
        few=views.points[cells.first(cell, region, count, _FEW)[0]],
    )


def shapes(views: Views, cells: Cells, cell: Tensor, region: Tensor, inner: Tensor) -> Shapes:
    """Measure the first pixels of each region, as `places`; `inner`: (R,) how many its interior has."""
    pixel, count = cells.first(cell, region, len(inner), _SAMPLES)
    samples, sampled = kept_samples(views.points[pixel], count, _KEPT)
    plane = sample_planes(samples, sampled)
    outside = torch.arange(samples.shape[1]) >= sampled[:, None]
    lowest = samples[..., 1].masked_fill(outside, torch.inf).amin(dim=1)
    highest = samples[..., 1].masked_fill(outside, -torch.inf).amax(dim=1)
    base = footprint_area(samples, sampled)
    volume = ((highest - lowest) * base).clamp(min=_MIN_VOLUME)
    return Shapes(
        samples=samples,
        sampled=sampled,
        plane=plane,
        residual=residuals(samples, sampled, plane),
        volume=volume,
        base=base.clamp(min=_MIN_AREA),
        height=highest - lowest,
        density=inner / volume,
        rise=torch.stack([lowest, highest], dim=1) - views.lowest,
    )
