"""Groups of pixels measured once, so that what holds for any union of them follows quickly."""

from __future__ import annotations

from dataclasses import dataclass

import torch
from torch import Tensor

from blockstab.features.appearance.grouping import extreme, first_of_each, summed, tables
from blockstab.features.appearance.views import FACINGS, Views
from blockstab.segments.runs import spans

MOMENT = ((3, 4, 5, 0), (4, 6, 7, 1), (5, 7, 8, 2), (0, 1, 2, 9))
"""Where the mean of (x, y, z, 1) times its transpose is found among moments."""
_DRAWN = 2  # times as many pixels are looked at as are wanted, to find the first ones


@dataclass(frozen=True)
class Cells:
    """C groups of pixels of an image, of which each has only pixels with depth, or only pixels without.

    Args:
        pixel: (N,) int64 pixels, cell after cell, each in the order of `Views.order`.
        key: (N,) int64, sorted: their cells, times `total`, plus their places in that order.
        start, pixels: (C,) int64, where the pixels of each begin, and how many it has.
        total: of the pixels of the image.
        measured: (C,) bool, whether they have depth.
        colors: (C, 8) sums of the four colours, and of their squares.
        moments: (C, 10) sums of x, y, z, xx, xy, xz, yy, yz, zz and 1.
        least, greatest: (C, 4) of x, y, z and depth.
        normals: (C, 2, 3) sums over the pixels that have one.
        facing: (C, 2, 13) how many of these are of each kind of surface, and in each quarter of inclination and
            azimuth.
        planes: (C, P + 1) how many pixels have each label of a plane.
    """

    pixel: Tensor
    key: Tensor
    start: Tensor
    pixels: Tensor
    total: int
    measured: Tensor
    colors: Tensor
    moments: Tensor
    least: Tensor
    greatest: Tensor
    normals: Tensor
    facing: Tensor
    planes: Tensor

    def first(self, cell: Tensor, union: Tensor, count: int, most: int) -> tuple[Tensor, Tensor]:
        """The first pixels, in the order of `Views.order`, of unions of cells.

        Args:
            cell, union: (K,) int64 cells, and which of the `count` unions each belongs to; every one needs a pixel.

        Returns:
            (count, most) int64 pixels, which begin again where a union has fewer; and (count,) how many differ.
        """
        size = summed(self.pixels[cell], union, count)
        # Ranks are random, so that the wanted ones are almost surely among the least; else all are looked at.
        bound = (_DRAWN * most * self.total // size).clamp(max=self.total)
        taken = torch.searchsorted(self.key, cell * self.total + bound[union]) - self.start[cell]
        few = summed(taken, union, count) < size.clamp(max=most)
        taken = torch.where(few[union], self.pixels[cell], taken)
        place, entry = spans(self.start[cell], taken)
        order = (union[entry] * self.total + self.key[place] % self.total).argsort()
        first, differ = first_of_each(union[entry[order]], count, most)
        return self.pixel[place[order[first]]], differ


def measured_cells(views: Views, cell: Tensor, count: int) -> Cells:
    """Measure cells.

    Args:
        cell: (M,) int64, from 0 to `count` - 1, which cell each pixel of the image belongs to; -1 for none. No cell
            may have both pixels with depth and without.
    """
    inside = (cell >= 0).nonzero()[:, 0]
    own, known = cell[inside], inside[views.has_normal[inside]]
    pixels = torch.bincount(own, minlength=count)
    by_rank = views.order[cell[views.order] >= 0]
    by_cell = by_rank[cell[by_rank].argsort(stable=True)]
    rank = torch.empty_like(views.order)
    rank[views.order] = torch.arange(len(rank))
    colors, points = views.colors[inside], views.points[inside]
    products = points[:, [0, 0, 0, 1, 1, 2]] * points[:, [0, 1, 2, 1, 2, 2]]
    spread = torch.cat([points, views.depth[inside, None]], dim=1)
    return Cells(
        pixel=by_cell,
        key=cell[by_cell] * len(cell) + rank[by_cell],
        start=pixels.cumsum(0) - pixels,
        pixels=pixels,
        total=len(cell),
        measured=torch.bincount(own[views.measured[inside]], minlength=count) > 0,
        colors=summed(torch.cat([colors, colors.square()], dim=1), own, count),
        moments=torch.cat(
            [summed(points, own, count), summed(products, own, count), pixels[:, None].double()], dim=1
        ),
        least=extreme(spread, own, count, "amin"),
        greatest=extreme(spread, own, count, "amax"),
        normals=summed(views.normals[known], cell[known], count),
        facing=torch.stack([_facing(views.facing[known, k], cell[known], count) for k in range(2)], dim=1),
        planes=tables(views.plane[inside], own, count, int(views.plane.amax()) + 1),
    )


def _facing(facing: Tensor, cell: Tensor, count: int) -> Tensor:
    table = tables(facing, cell, count, FACINGS[0] * FACINGS[1] * FACINGS[2]).view(-1, *FACINGS)
    return torch.cat([table.sum(dim=(2, 3)), table.sum(dim=(1, 3)), table.sum(dim=(1, 2))], dim=1)
