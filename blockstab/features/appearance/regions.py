"""Measurements of single regions, from which the appearance of their borders is told (Silberman et al. 2012)."""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Any

import torch
from torch import Tensor

from blockstab.features.appearance.cells import Cells, measured_cells
from blockstab.features.appearance.grouping import or_all, summed
from blockstab.features.appearance.interior import near_others
from blockstab.features.appearance.shapes import Places, Shapes, places, shapes
from blockstab.features.appearance.views import Views, view
from blockstab.observation import Observation

_FEWEST = 3  # pixels of the interior; regions with fewer are sampled everywhere


@dataclass(frozen=True)
class Colors:
    """Colours of R regions, 0 to 1; of the interior, and of the border.

    Args:
        mean, deviation: (R, 2, 3), of Y, Cb and Cr.
        value_deviation: (R, 2), of the value of HSV.
    """

    mean: Tensor
    deviation: Tensor
    value_deviation: Tensor


@dataclass(frozen=True)
class Regions:
    """R regions of an image, in a frame that is aligned with the room, y up.

    A set of pixels that is empty (the interior of a thin region, say) is replaced by the whole region, and a region
    without depth has the points of the nearest pixels that have some.

    Args:
        share: (R,) of the pixels of the image.
        colors: of all pixels.
        places: of the pixels with depth.
        shapes: of random pixels of the interior.
        facing: (R, 2, 18), the mean size of the three components of the normals; shares of pixels that are
            horizontal, vertical, wall_1, wall_2, either wall, vertical and no wall, slanted; shares by quarters of
            the inclination and of the azimuth. In the room, and as the authors' program has them.
        planes: (R, P + 1) shares of pixels by the label of their plane.
    """

    share: Tensor
    colors: Colors
    places: Places
    shapes: Shapes
    facing: Tensor
    planes: Tensor

    def __len__(self) -> int:
        return len(self.share)


def describe_regions(observation: Observation, label: Tensor) -> Regions:
    """Measure the regions of a label image.

    Args:
        label: (H, W) int64, 0 = none, regions from 1 without gaps.

    Raises:
        ValueError: if the size is not the image's or the numbers have gaps.
    """
    if label.shape != observation.cloud.valid.shape:
        raise ValueError(
            f"Labels must have the size of the image, {tuple(observation.cloud.valid.shape)}, but they have "
            f"{tuple(label.shape)}; compute both from the same image."
        )
    return viewed_regions(view(observation), label)


def viewed_regions(views: Views, label: Tensor) -> Regions:
    """Measure the regions of a label image, as `describe_regions`, in an image that has been prepared."""
    pixels = torch.bincount(label.flatten(), minlength=1)[1:]
    if bool((pixels == 0).any()):
        missing = int((pixels == 0).nonzero()[0]) + 1
        raise ValueError(
            f"Regions must be numbered from 1 without gaps, but {missing} is missing; renumber them."
        )
    # Four cells to a region: interior or border, with depth or without.
    inside = ~near_others(label).flatten()
    number = 4 * (label.flatten() - 1) + 2 * inside + views.measured
    cells = measured_cells(views, number.clamp(min=-1), 4 * len(pixels))
    cell = cells.pixels.nonzero()[:, 0]
    return measured_regions(views, cells, cell, cell // 4, cell % 4 > 1, len(pixels))


def joined(one: Regions, more: Regions) -> Regions:
    """The regions of both, in order; of one image."""
    both: Regions = _joined(one, more)
    return both


def measured_regions(
    views: Views, cells: Cells, cell: Tensor, region: Tensor, interior: Tensor, count: int
) -> Regions:
    """Measure unions of cells.

    Args:
        cell, region: (K,) int64 cells that are not empty, and the region from 0 to `count` - 1 that each is part of;
            every region needs one.
        interior: (K,) bool, which of them are no border.
    """
    pixels = cells.pixels[cell]
    seen = or_all(cells.measured[cell], pixels, region, count, 1)
    sampled = or_all(interior & seen, pixels, region, count, _FEWEST) & seen
    planes = summed(cells.planes[cell], region, count)
    return Regions(
        share=summed(pixels, region, count).double() / cells.total,
        colors=_colors(cells, cell, region, interior, count),
        places=places(views, cells, cell[seen], region[seen], count),
        shapes=shapes(views, cells, cell[sampled], region[sampled], summed(pixels * interior, region, count)),
        facing=_facing(cells, cell, region, count),
        planes=planes / planes.sum(dim=1, keepdim=True),
    )


def _colors(cells: Cells, cell: Tensor, region: Tensor, interior: Tensor, count: int) -> Colors:
    part = 2 * region + (~interior).to(torch.int64)
    number = summed(cells.pixels[cell], part, 2 * count).view(-1, 2, 1)
    total = summed(cells.colors[cell], part, 2 * count).view(-1, 2, 8)
    whole = total.sum(dim=1, keepdim=True) / number.sum(dim=1, keepdim=True)
    moments = torch.where(number > 0, total / number.clamp(min=1), whole)
    mean, square = moments[..., :4], moments[..., 4:]
    deviation = (square - mean.square()).clamp(min=0.0).sqrt()
    return Colors(mean[..., :3], deviation[..., :3], deviation[..., 3])


def _facing(cells: Cells, cell: Tensor, region: Tensor, count: int) -> Tensor:
    facing = summed(cells.facing[cell], region, count)
    known = facing[..., :5].sum(dim=2, keepdim=True).clamp(min=1.0)
    horizontal, wall_1, wall_2, other, slanted = (facing[..., :5] / known).unbind(dim=2)
    wall = wall_1 + wall_2
    classes = torch.stack([horizontal, wall + other, wall_1, wall_2, wall, other, slanted], dim=2)
    size = summed(cells.normals[cell], region, count) / known
    return torch.cat([size, classes, facing[..., 5:] / known], dim=2)


def _joined(one: Any, more: Any) -> Any:
    if isinstance(one, Tensor):
        return torch.cat([one, more])
    return type(one)(*(_joined(getattr(one, f.name), getattr(more, f.name)) for f in fields(one)))
