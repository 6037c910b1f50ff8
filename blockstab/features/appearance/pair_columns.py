"""The 51 features of a border between two regions, from how it looks (Silberman et al. 2012)."""

from __future__ import annotations

import torch
import torch.nn.functional as F
from torch import Tensor

from blockstab.boundaries import BoundaryMap
from blockstab.features.appearance.contrast import CONTRAST_COLUMNS, Variant, contrast
from blockstab.features.appearance.regions import Regions, describe_regions
from blockstab.segments.edgelets import Edgelets

__all__ = ["APPEARANCE_COLUMNS", "Variant", "describe_regions", "edgelet_appearance", "pair_appearance"]

COURSE_COLUMNS = ("strength", "relative_length", "smoothness", "continuity_least", "continuity_greatest")
APPEARANCE_COLUMNS = (*COURSE_COLUMNS, *CONTRAST_COLUMNS)
_BESIDE_PX = 2  # how far from a crack the edge that it follows may run


def edgelet_appearance(
    regions: Regions, edgelets: Edgelets, boundaries: BoundaryMap, variant: Variant = "fixed"
) -> Tensor:
    """Features of edgelets, (L, 51) float64, in the order of `APPEARANCE_COLUMNS`.

    Args:
        regions: those that the edgelets part, all of them.
        variant: "released" repeats the slips of the authors' program; but the angles of continuity, of whose slip
            only the fact is known, are the same.
    """
    count = max(len(regions), 1)
    pairs, place = torch.unique(edgelets.first * count + edgelets.second, return_inverse=True)
    between = contrast(regions, pairs // count, pairs % count, variant)
    both = torch.cat([edgelets.first, edgelets.second])
    perimeter = torch.bincount(both, edgelets.length.repeat(2), minlength=len(regions))
    return torch.cat([course(edgelets, perimeter, widened(boundaries), variant), between[place]], dim=1)


def pair_appearance(rows: Tensor, edgelets: Edgelets) -> tuple[Tensor, Tensor, Tensor]:
    """Features of pairs of regions, from those of the edgelets between them, (L, 51).

    Those of the course are pooled as in `pooled`; all else is the same along the border.

    Returns:
        (P,) and (P,) int64 regions, the smaller first, sorted; and (P, 51) float64.
    """
    first, second, whole, start = pooled(rows[:, : len(COURSE_COLUMNS)], edgelets)
    return first, second, torch.cat([whole, rows[start, len(COURSE_COLUMNS) :]], dim=1)


def course(edgelets: Edgelets, perimeter: Tensor, wide: Tensor, variant: Variant) -> Tensor:
    """The features that depend on the course of edgelets, (L, 5) float64, in the order of `COURSE_COLUMNS`.

    Args:
        perimeter: (R,) of each region, cracks.
        wide: as `widened` gives it.
    """
    columns = [
        border_strength(edgelets, wide),
        edgelets.length / torch.minimum(perimeter[edgelets.first], perimeter[edgelets.second]),
        smoothness(edgelets, variant),
        edgelets.continuity.amin(dim=1),
        edgelets.continuity.amax(dim=1),
    ]
    return torch.stack(columns, dim=1)


def pooled(rows: Tensor, edgelets: Edgelets) -> tuple[Tensor, Tensor, Tensor, Tensor]:
    """The same of the whole border of two regions, from what `course` says of its edgelets, (L, 5).

    Relative lengths add up; strength and smoothness are means, weighted by length; continuity is the least and the
    greatest.

    Returns:
        (P,) and (P,) int64 regions, the smaller first, sorted; (P, 5) float64; and (P,) int64, the first edgelet of
        each pair.
    """
    pairs = torch.stack([edgelets.first, edgelets.second], dim=1)
    pairs, count = torch.unique_consecutive(pairs, return_counts=True, dim=0)
    place = torch.arange(len(pairs)).repeat_interleave(count)
    start = count.cumsum(0) - count
    whole, length = rows[start], edgelets.length[:, None]
    total = torch.zeros(len(pairs), 4, dtype=torch.float64)
    total = total.index_add(0, place, torch.cat([rows[:, [0, 2]] * length, rows[:, 1:2], length], dim=1))
    whole[:, [0, 2]], whole[:, 1] = total[:, :2] / total[:, 3:], total[:, 2]
    whole[:, 3] = whole[:, 3].scatter_reduce(0, place, rows[:, 3], "amin")
    whole[:, 4] = whole[:, 4].scatter_reduce(0, place, rows[:, 4], "amax")
    return pairs[:, 0], pairs[:, 1], whole, start


def widened(boundaries: BoundaryMap) -> Tensor:
    """(4, H, W) the greatest strength within two pixels, because an edge may run beside a crack."""
    size = 2 * _BESIDE_PX + 1
    wide = F.max_pool2d(boundaries.oriented[None], (1, size), stride=1, padding=(0, _BESIDE_PX))
    return F.max_pool2d(wide, (size, 1), stride=1, padding=(_BESIDE_PX, 0))[0]


def border_strength(edgelets: Edgelets, wide: Tensor) -> Tensor:
    """(L,) mean strength along edgelets, in the channel that runs most nearly their way.

    Args:
        wide: as `widened` gives it; of the two sides of a crack the greater value counts.
    """
    channel = (edgelets.angle / 45.0).round().long() % 4
    row, column = edgelets.cracks.unbind(dim=-1)
    along = wide[channel[edgelets.edgelet][:, None], row, column].amax(dim=1)
    return torch.bincount(edgelets.edgelet, along, minlength=len(edgelets)) / edgelets.length


def smoothness(edgelets: Edgelets, variant: Variant) -> Tensor:
    """(L,) how directly edgelets run, from 0 to 1: 1 where they never turn back.

    As released, it is nearly 1 for all, and exactly 1 for those that do turn back.
    """
    direct = (edgelets.ends[:, 0] - edgelets.ends[:, 1]).abs().sum(dim=1) + 1
    if variant == "released":
        return (edgelets.length / direct).clamp(max=1.0)
    return direct / (edgelets.length + 1)
