"""The finest partition of an image: every segment is a set of atoms."""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import product

import torch
import torch.nn.functional as F
from torch import Tensor

from blockstab.segments.contraction import borders_between, smallest_first
from blockstab.segments.flooding import basins
from blockstab.segments.gaps import fill_gaps, without_gaps
from blockstab.segments.pieces import connected_pieces, without_small_pieces
from blockstab.segments.shadows import cast_on

MIN_ATOM_PX = 25


@dataclass(frozen=True)
class Atoms:
    """A partition of the labelled pixels, and which parts touch.

    Args:
        label: (H, W) int64; 0 = no atom, 1..A = atoms. In every other place atom a is index `a - 1`.
        pixel_count: (A,) int64, pixels of each atom.
        first, second: (E,) int64 atom indices, first < second, each touching pair once, sorted.
        border_px: (E,) float64 length of the shared border, pixels.
        strength: (E,) float64 mean boundary strength along the border, 0 to 1; low = likely inside one
            object.
    """

    label: Tensor
    pixel_count: Tensor
    first: Tensor
    second: Tensor
    border_px: Tensor
    strength: Tensor

    def __len__(self) -> int:
        return self.pixel_count.shape[0]


def make_atoms(label: Tensor, strength: Tensor) -> Atoms:
    """Measure a partition: the size of every part, and every border between two parts.

    Args:
        label: (H, W) int64 parts, numbered from 1 without gaps; 0 = none.
        strength: (H, W) float64 boundary strength. At each of its pixels a border takes the greater value of
            its two sides, because an edge may run on either.

    Raises:
        ValueError: if the sizes differ or the numbers have gaps.
    """
    if label.shape != strength.shape:
        raise ValueError(
            f"Labels and strength must have one size, but they have {tuple(label.shape)} and "
            f"{tuple(strength.shape)} pixels; compute both from the same image."
        )
    pixels = torch.bincount(label.flatten())[1:]
    if bool((pixels == 0).any()):
        missing = int((pixels == 0).nonzero()[0]) + 1
        raise ValueError(
            f"Atoms must be numbered from 1 without gaps, but {missing} is missing; renumber them."
        )
    count = len(pixels)
    below, below_strength = _meeting(label[:-1], label[1:], strength[:-1], strength[1:], count)
    beside, beside_strength = _meeting(label[:, :-1], label[:, 1:], strength[:, :-1], strength[:, 1:], count)
    pairs, index = torch.unique(torch.cat([below, beside]), return_inverse=True)
    border_px = torch.bincount(index, minlength=len(pairs)).double()
    total = torch.bincount(index, torch.cat([below_strength, beside_strength]), minlength=len(pairs))
    return Atoms(label, pixels, pairs // max(count, 1), pairs % max(count, 1), border_px, total / border_px)


def over_segment(
    strength: Tensor, valid: Tensor, plane: Tensor | None = None, shadow: Tensor | None = None
) -> Tensor:
    """Cut an image into atoms by flooding its boundary strength, and along its planes.

    Args:
        strength: (H, W) float64, 0 to 1.
        valid: (H, W) bool, where depth was measured.
        plane: (H, W) int64, which plane a pixel lies on, 0 = none. An atom keeps to one, or to none, but for what is
            smaller than an atom, or so slim that no square of 3 x 3 pixels fits in it: that joins a neighbour.
        shadow: (H, W) int64, as `shadows` gives it. A pixel in a shadow goes with what the shadow lies on.

    Returns:
        (H, W) int64, 0 = none, atoms from 1. Every atom is 4-connected and has at least `MIN_ATOM_PX` pixels.
        Together they cover the valid pixels and the small gaps between them, but for islands that are smaller
        than an atom.
    """
    area = without_small_pieces(without_gaps(valid).to(torch.int64), MIN_ATOM_PX) > 0
    parts = basins(strength, area)
    plane = torch.zeros_like(parts) if plane is None else plane
    # Gaps have no plane of their own, and lie between pixels that do.
    plane = fill_gaps(torch.where(valid, plane + 1, 0))
    if shadow is not None:
        parts, plane = cast_on(parts, shadow), cast_on(plane, shadow)
    parts = connected_pieces(torch.where(area, plane * (parts.max() + 1) + parts, 0))
    atoms = make_atoms(parts, strength)
    # Where two edges run side by side, as that of a basin and that of a plane, what lies between means nothing.
    return absorb_small(
        replace(atoms, pixel_count=torch.where(_slim(atoms), 0, atoms.pixel_count)), MIN_ATOM_PX
    )


def absorb_small(atoms: Atoms, least_px: int) -> Tensor:
    """Merge parts of fewer than `least_px` pixels, the smallest first, across their weakest border.

    Of equally weak borders the longest is removed. A part without neighbours stays as it is.

    Returns:
        (H, W) int64, 0 = none, the new parts from 1.
    """
    borders = borders_between(len(atoms), atoms.first, atoms.second, atoms.border_px, atoms.strength)
    owner = torch.tensor(smallest_first(borders, atoms.pixel_count.tolist(), least_px), dtype=torch.int64)
    number = torch.unique(owner, return_inverse=True)[1] + 1
    return F.pad(number, (1, 0))[atoms.label]


def join(fine: Tensor, coarse: Tensor) -> Tensor:
    """The intersection of two partitions, so that every coarse region is a union of parts.

    Args:
        fine, coarse: (H, W) int64, 0 = none. Where only the coarse one has a label, it stands alone; where it
            has none, the result has none.

    Returns:
        (H, W) int64, 0 = none, parts from 1. Every part is 4-connected. Parts of fewer than `MIN_ATOM_PX`
        pixels go to a neighbour in the same coarse region, where there is one.
    """
    if fine.shape != coarse.shape:
        raise ValueError(
            f"Partitions must have one size, but they have {tuple(fine.shape)} and {tuple(coarse.shape)} "
            "pixels; compute both from the same image."
        )
    both = torch.where(coarse > 0, coarse * (fine.max() + 1) + fine, 0)
    parts = make_atoms(connected_pieces(both), torch.zeros(both.shape, dtype=torch.float64))
    region = torch.zeros(len(parts) + 1, dtype=torch.int64)
    region[parts.label] = coarse
    same = region[parts.first + 1] == region[parts.second + 1]
    inner = replace(
        parts,
        first=parts.first[same],
        second=parts.second[same],
        border_px=parts.border_px[same],
        strength=parts.strength[same],
    )
    return absorb_small(inner, MIN_ATOM_PX)


def _meeting(
    a: Tensor, b: Tensor, strength_a: Tensor, strength_b: Tensor, count: int
) -> tuple[Tensor, Tensor]:
    """For each pair of pixels across a border: a number for its two atoms, and the greater strength."""
    border = (a != b) & (a > 0) & (b > 0)
    a, b = a[border] - 1, b[border] - 1
    pair = torch.minimum(a, b) * count + torch.maximum(a, b)
    return pair, torch.maximum(strength_a[border], strength_b[border])


def _slim(atoms: Atoms) -> Tensor:
    """(A,) bool: the atoms in which no square of 3 x 3 pixels fits."""
    height, width = atoms.label.shape
    padded = F.pad(atoms.label, (1, 1, 1, 1))
    inner = atoms.label > 0
    for row, column in product(range(3), repeat=2):
        inner &= padded[row : row + height, column : column + width] == atoms.label
    return torch.bincount(atoms.label[inner], minlength=len(atoms) + 1)[1:] == 0
