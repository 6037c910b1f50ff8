"""Edgelets between pairs of segments, each pair alone in an image where all else is one region."""

from __future__ import annotations

from dataclasses import dataclass, replace

import torch
import torch.nn.functional as F
from torch import Tensor

from blockstab.segments.atoms import Atoms
from blockstab.segments.edgelets import (
    TANGENT_CRACKS,
    Cracks,
    Edgelets,
    continuity,
    cracks_of,
    edgelets_of,
)
from blockstab.segments.runs import spans

_REST, _FIRST, _SECOND, _OUTSIDE = range(4)  # what a pixel belongs to, as one pair of segments sees it
# What is around a corner is told by one number, to which the pixels add, clockwise from the upper left.
_PLACES = torch.tensor([1, 4, 16, 64])
_AROUND = torch.arange(256)[:, None] // _PLACES % 4
_AFTER = _AROUND.roll(-1, dims=1)
# Whether there is a crack upwards, to the right, down, and to the left of the corner.
_CRACKS = (_AROUND != _AFTER) & (_AROUND != _OUTSIDE) & (_AFTER != _OUTSIDE)
_OUTER = _CRACKS & ((_AROUND == _REST) | (_AFTER == _REST))
_STOP = -1


class Outlines:
    """The cracks between the atoms of an image, to trace the borders of any sets of atoms."""

    def __init__(self, atoms: Atoms) -> None:
        """Sort the cracks by the atoms that they part."""
        label, count = atoms.label, len(atoms)
        cracks = cracks_of(label)
        self._cracks = cracks[(cracks.regions >= 0).all(dim=1)]
        first, second = self._cracks.regions.sort(dim=1).values.T
        parted = torch.searchsorted(atoms.first * count + atoms.second, first * count + second)
        self._by_parted = parted.argsort(stable=True)
        self._number = torch.bincount(parted, minlength=len(atoms.first))
        self._start = self._number.cumsum(0) - self._number
        self._atoms, self._shape = atoms, (label.shape[0], label.shape[1])
        # In a table of atoms, what has no label comes after all of them, and what is outside the image last.
        columns = torch.where(label > 0, label - 1, count)
        self._padded = F.pad(columns, (1, 1, 1, 1), value=count + 1).flatten()

    def perimeter(self, inside: Tensor) -> Tensor:
        """(S,) float64 cracks that part sets of atoms from others; what has no label is none.

        Args:
            inside: (S, A + 1) bool, which atoms each has; the last column false.
        """
        parted = inside[:, self._atoms.first] != inside[:, self._atoms.second]
        return (parted * self._atoms.border_px).sum(dim=1)

    def edgelets(self, first: Tensor, second: Tensor) -> Edgelets:
        """Trace the border of each of P pairs of sets of atoms, as if everything else were one region.

        An edgelet runs from where the two meet something else, or the end of the image, to where they do again; its
        continuity is that into the other borders of the two.

        Args:
            first, second: (P, A + 1) bool, which atoms each has, none in common; the last column false.

        Returns:
            Edgelets of pair p have the regions 2 p and 2 p + 1.
        """
        side = F.pad(_FIRST * first + _SECOND * second, (0, 1), value=_OUTSIDE)
        between = side[:, self._atoms.first] + side[:, self._atoms.second] == _FIRST + _SECOND
        pair, parted = between.nonzero().T
        place, entry = spans(self._start[parted], self._number[parted])
        # In the order that they have in the image, for it decides where a closed edgelet starts.
        ordered = (pair[entry] * len(self._by_parted) + self._by_parted[place]).sort().values
        pair, cracks = ordered // len(self._by_parted), self._cracks[ordered % len(self._by_parted)]
        own = 2 * pair[:, None] + side[pair[:, None], cracks.regions] - _FIRST
        seen = _Seen(side, self._padded, self._shape[1] + 2)
        through = _CRACKS[seen(pair[:, None], self._upper_left(cracks.corners))].sum(dim=-1) == 2
        corners = (self._shape[0] + 1) * (self._shape[1] + 1)
        apart = Cracks(cracks.pixels, own, pair[:, None] * corners + cracks.corners)
        edgelets = edgelets_of(apart, through, self._shape)
        return replace(edgelets, continuity=_continuity(edgelets, seen))

    def _upper_left(self, corner: Tensor) -> Tensor:
        """Of the pixels around corners of the image, the first, in the image that is padded."""
        return corner + corner // (self._shape[1] + 1)


@dataclass(frozen=True)
class _Seen:
    """The image as each of P pairs of segments sees it.

    Args:
        side: (P, A + 2) int64 of each atom, of what has no label, and of what is outside.
        padded: (M,) int64, the columns of `side` for all pixels, row by row, with one pixel around the image.
        stride: pixels of a row.
    """

    side: Tensor
    padded: Tensor
    stride: int

    def __call__(self, pair: Tensor, corner: Tensor) -> Tensor:
        """(...,) int64, what lies around corners, which are named by their upper left pixel."""
        around = self.padded[corner[..., None] + torch.tensor([0, 1, self.stride + 1, self.stride])]
        return (self.side[pair[..., None], around] * _PLACES).sum(dim=-1)

    def steps(self) -> Tensor:
        """(4,) from a corner to the next one upwards, to the right, down, and to the left."""
        return torch.tensor([-self.stride, 1, self.stride, -1])


def _continuity(edgelets: Edgelets, seen: _Seen) -> Tensor:
    """(L, 2) as in `Edgelets`, into each other and into the borders that the two have with anything else."""
    size = len(seen.padded)
    place = (edgelets.ends @ edgelets.ends.new_tensor([seen.stride, 1])).long()
    tips = (edgelets.first // 2)[:, None] * size + place
    node = torch.unique(tips)
    entry, way = _OUTER[seen(node // size, node % size)].nonzero().T
    start = node[entry]
    tangents = F.pad(_tangents(seen, start // size, start % size, way)[:, None], (0, 0, 0, 1))
    far = torch.stack([start, -1 - torch.arange(len(start))], dim=1)  # whose other ends meet nothing
    return continuity(torch.cat([tips, far]), torch.cat([edgelets.tangents, tangents]))[: len(edgelets)]


def _tangents(seen: _Seen, pair: Tensor, start: Tensor, way: Tensor) -> Tensor:
    """(N, 2) the unit vectors, row and column, in which borders run from corners where they end."""
    steps, onwards = seen.steps(), _onwards()
    corner, path = start, [start]
    for _ in range(2 * TANGENT_CRACKS):
        going = way != _STOP
        corner = torch.where(going, corner + steps[way], corner)
        way = torch.where(going, onwards[seen(pair, corner), way], way)
        path.append(corner)
    passed = torch.stack(path, dim=1)
    count = (passed[:, 1:] != passed[:, :-1]).sum(dim=1)
    # One that comes back to where it started has a direction only as far as half way round.
    reach = torch.where(corner == start, count // 2, count).clamp(max=TANGENT_CRACKS)
    there = passed.gather(1, reach[:, None])[:, 0]
    rows = there // seen.stride - start // seen.stride
    columns = there % seen.stride - start % seen.stride
    return F.normalize(torch.stack([rows, columns], dim=1).double(), dim=1)


def _onwards() -> Tensor:
    """(256, 4) int64: by what is around a corner, and the way that leads to it, the way on; `_STOP` where it ends."""
    back = torch.eye(4, dtype=torch.bool).roll(2, dims=1)  # after a way, the crack that one came from
    others = _CRACKS[:, None] & ~back
    return torch.where(others.sum(dim=2) == 1, others.to(torch.int64).argmax(dim=2), _STOP)
