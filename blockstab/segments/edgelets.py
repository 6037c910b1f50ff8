"""Edgelets: the borders between regions, cut where they meet (Silberman et al. 2012, after Hoiem et al. 2011)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import torch
import torch.nn.functional as F
from torch import Tensor

from blockstab.segments.chains import chained

TANGENT_CRACKS = 10  # a tangent is the direction over that many

_MOST = 4  # edgelets end at one corner


@dataclass(frozen=True)
class Cracks:
    """The sides that pixels of different regions share.

    Args:
        pixels: (K, 2, 2) int64, row and column of the pixel on either side.
        regions: (K, 2) int64, index of the region on either side; -1 for none.
        corners: (K, 2) int64, the corners of pixels it runs between: row times (W + 1) plus column.
    """

    pixels: Tensor
    regions: Tensor
    corners: Tensor

    def __getitem__(self, rows: Tensor) -> Cracks:
        return Cracks(self.pixels[rows], self.regions[rows], self.corners[rows])


@dataclass(frozen=True)
class Edgelets:
    """L edgelets, sorted by the two regions that they part; a pair of regions may have several.

    Args:
        first, second: (L,) int64 region indices, first < second.
        length: (L,) float64, cracks.
        ends: (L, 2, 2) float64, row and column of the corner where it starts, and where it ends; corner (r, c)
            is the upper left one of pixel (r, c).
        tangents: (L, 2, 2) float64 unit vectors, row and column, pointing from either end into the edgelet; over
            its first or last `TANGENT_CRACKS` cracks.
        continuity: (L, 2) float64, degrees in [0, 180]: at either end, the least turn from this edgelet into
            another one that meets it; 0 where none does.
        angle: (L,) float64, degrees in [0, 180): of the line from end to end, counter-clockwise from the image's x
            axis as one sees it; of a closed edgelet, of the line from its start to half way round.
        cracks: (K, 2, 2) int64, row and column of the pixels on both sides of each crack, that of `first` first;
            in order along each edgelet.
        edgelet: (K,) int64, which edgelet each crack belongs to, sorted.
    """

    first: Tensor
    second: Tensor
    length: Tensor
    ends: Tensor
    tangents: Tensor
    continuity: Tensor
    angle: Tensor
    cracks: Tensor
    edgelet: Tensor

    def __len__(self) -> int:
        return len(self.first)


def trace_edgelets(label: Tensor) -> Edgelets:
    """Trace the borders between regions.

    An edgelet runs from junction to junction: corners where three regions meet, counting what has no label as one,
    or two do like squares of a chessboard; or where the image ends. One that meets no junction is closed.

    Args:
        label: (H, W) int64, 0 = none, regions from 1; their indices are one less.

    Raises:
        ValueError: if the labels are no image.
    """
    if label.ndim != 2:
        raise ValueError(
            f"Labels must be an image, (H, W), but their shape is {tuple(label.shape)}; give one number a pixel."
        )
    cracks = cracks_of(label)
    corners = (label.shape[0] + 1) * (label.shape[1] + 1)
    meeting = torch.bincount(cracks.corners.flatten(), minlength=corners)
    inner = cracks[(cracks.regions >= 0).all(dim=1)]
    return edgelets_of(inner, (meeting == 2)[inner.corners], (label.shape[0], label.shape[1]))


def cracks_of(label: Tensor) -> Cracks:
    """All cracks of an (H, W) label image, those beside pixels without label among them."""
    stride = label.shape[1] + 1
    upright = (label[:, :-1] != label[:, 1:]).nonzero()
    level = (label[:-1] != label[1:]).nonzero()
    right, down = upright.new_tensor([0, 1]), upright.new_tensor([1, 0])
    one, other = torch.cat([upright, level]), torch.cat([upright + right, level + down])
    start = other[:, 0] * stride + other[:, 1]
    end = torch.cat([start[: len(upright)] + stride, start[len(upright) :] + 1])
    pixels = torch.stack([one, other], dim=1)
    return Cracks(pixels, label[pixels[..., 0], pixels[..., 1]] - 1, torch.stack([start, end], dim=1))


def edgelets_of(cracks: Cracks, through: Tensor, shape: tuple[int, int]) -> Edgelets:
    """Put cracks between regions together to edgelets.

    Args:
        cracks: between two regions each; corners may be numbered several times over, from multiples of
            (H + 1) (W + 1), to keep cracks apart that are not of one image.
        through: (K, 2) bool, the ends of cracks that are joined to another, exactly two at each of their corners.
        shape: of the image, H and W.
    """
    chain, left, forward = chained(cracks.corners, through)
    order = torch.from_numpy(np.lexsort((-left, chain, *cracks.regions.sort(dim=1).values.T.flip(0))))
    edgelet, count = torch.unique_consecutive(chain[order], return_inverse=True, return_counts=True)[1:]
    stop = count.cumsum(0)
    start = stop - count
    path = torch.where(forward[:, None], cracks.corners, cracks.corners.flip(1))[order]
    tips = torch.stack([path[start, 0], path[stop - 1, 1]], dim=1)
    closed = tips[:, 0] == tips[:, 1]
    half = path[start + count // 2 - 1, 1]
    reach = torch.where(closed, count // 2, count).clamp(max=TANGENT_CRACKS)
    inside = torch.stack([path[start + reach - 1, 1], path[stop - reach, 0]], dim=1)
    ends = _position(tips, shape)
    tangents = F.normalize(_position(inside, shape) - ends, dim=-1)
    chord = _position(torch.where(closed, half, tips[:, 1]), shape) - ends[:, 0]

    rising = cracks.regions[:, 0] < cracks.regions[:, 1]
    pixels = torch.where(rising[:, None, None], cracks.pixels, cracks.pixels.flip(1))[order]
    first, second = cracks.regions[order[start]].sort(dim=1).values.T
    angle = _degrees(-chord[:, 0], chord[:, 1]) % 180.0
    length, turns = count.double(), continuity(tips, tangents)
    return Edgelets(first, second, length, ends, tangents, turns, angle, pixels, edgelet)


def continuity(tips: Tensor, tangents: Tensor) -> Tensor:
    """At each end of edgelets, the least turn into another edgelet that ends there; 0 where none does.

    Args:
        tips: (L, 2) int64, the corner at either end, by any numbers; at most four ends share one.
        tangents: (L, 2, 2) float64, as in `Edgelets`.

    Returns:
        (L, 2) float64, degrees in [0, 180].
    """
    corner, count = torch.unique(tips, return_inverse=True, return_counts=True)[1:]
    corner = corner.flatten()
    order = corner.argsort(stable=True)
    place = torch.arange(len(order)) - (count.cumsum(0) - count)[corner[order]]
    meeting = torch.full((len(count), _MOST), -1)
    meeting[corner[order], place] = order
    others = meeting[corner]  # (2 L, 4)
    own = torch.arange(len(corner))[:, None] // 2 == others // 2
    direction = tangents.flatten(0, 1)
    onwards, other = -direction[:, None], direction[others]
    across = onwards[..., 0] * other[..., 1] - onwards[..., 1] * other[..., 0]
    turn = _degrees(across.abs(), (onwards * other).sum(dim=-1))
    least = torch.where(own | (others < 0), torch.inf, turn).amin(dim=1)
    return torch.where(least.isinf(), 0.0, least).view(-1, 2)


def _position(corner: Tensor, shape: tuple[int, int]) -> Tensor:
    """(..., 2) float64 row and column of corners."""
    row, column = corner // (shape[1] + 1) % (shape[0] + 1), corner % (shape[1] + 1)
    return torch.stack([row, column], dim=-1).double()


def _degrees(y: Tensor, x: Tensor) -> Tensor:
    """Angles of points from the x axis."""
    # Not torch's arctangent: it rounds a number differently at the end of a list than in the middle.
    return torch.from_numpy(np.degrees(np.arctan2(y.numpy(), x.numpy())))
