"""Regions that are unions of atoms: which cells they hold, and what of them is interior."""

from __future__ import annotations

import torch
from torch import Tensor

from blockstab.features.appearance.cells import measured_cells
from blockstab.features.appearance.interior import others_near
from blockstab.features.appearance.regions import Regions, measured_regions
from blockstab.features.appearance.views import Views
from blockstab.segments.runs import spans


class UnionCells:
    """The pixels of atoms in cells, each of which is all interior or all border of any union of atoms.

    The pixels of a cell belong to one atom and are near the same other ones, so a union of atoms is measured
    without a look at the image.
    """

    def __init__(self, views: Views, label: Tensor) -> None:
        """Divide the pixels.

        Args:
            label: (H, W) int64, 0 = none, atoms from 1.
        """
        pixel, other = others_near(label)
        cell, atom = _alike(label.flatten(), views.measured, pixel, other)
        self._views = views
        self._cells = measured_cells(views, cell, len(atom))
        number = torch.bincount(pixel, minlength=label.numel())
        some = self._cells.pixel[self._cells.start]
        self._other_start, self._others = (number.cumsum(0) - number)[some], number[some]
        self._other = other - 1  # -1 is what has no label, and it is the last column of a table of atoms
        self._of_atom = torch.bincount(atom - 1, minlength=int(label.max()))
        self._start = self._of_atom.cumsum(0) - self._of_atom

    def regions(self, inside: Tensor) -> Regions:
        """Measure unions of atoms.

        Args:
            inside: (R, A + 1) bool, which atoms each has, at least one; the last column false.
        """
        region, atom = inside.nonzero().T
        cell, entry = spans(self._start[atom], self._of_atom[atom])
        region = region[entry]
        near, entry = spans(self._other_start[cell], self._others[cell])
        outside = ~inside[region[entry], self._other[near]]
        interior = torch.bincount(entry[outside], minlength=len(cell)) == 0
        return measured_regions(self._views, self._cells, cell, region, interior, len(inside))


def _alike(label: Tensor, measured: Tensor, pixel: Tensor, other: Tensor) -> tuple[Tensor, Tensor]:
    """Group pixels of one label that have depth, or have none, and that have the same others near.

    Args:
        label: (M,) int64, 0 = none; measured: (M,) bool.
        pixel, other: (N,) int64, as `interior.others_near` gives them.

    Returns:
        (M,) int64 groups from 0 without gaps, by label; -1 for pixels without one. And (G,) their labels.
    """
    number = torch.bincount(pixel, minlength=len(label))
    start = number.cumsum(0) - number
    group = 2 * label + measured
    more, labels = torch.arange(len(label)), int(label.max()) + 1
    for k in range(int(number.max())):
        more = more[number[more] > k]
        finer = torch.unique(group[more] * labels + other[start[more] + k], return_inverse=True)[1]
        group[more] = int(group.max()) + 1 + finer
    owner = torch.zeros(int(group.max()) + 1, dtype=torch.int64)
    owner[group] = label
    present = owner.nonzero()[:, 0]
    present = present[owner[present].argsort(stable=True)]
    index = torch.full_like(owner, -1)
    index[present] = torch.arange(len(present))
    return index[group], owner[present]
