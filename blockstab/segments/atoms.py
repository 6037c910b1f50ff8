"""The finest partition of an image: every segment is a set of atoms."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import torch
import torch.nn.functional as F
from kornia.filters import gaussian_blur2d
from skimage.measure import label as components
from skimage.morphology import local_minima
from skimage.segmentation import watershed
from torch import Tensor

from blockstab.segments.contraction import borders_between, smallest_first
from blockstab.segments.gaps import without_gaps

MIN_ATOM_PX = 25

_LEVEL = 0.02  # minima of the strength that differ by less are one
_BLUR_PX = 1.0  # standard deviation


@dataclass(frozen=True)
class Atoms:
    """A partition of the labelled pixels, and which parts touch.

    Args:
        label: (H, W) int64; 0 = no atom, 1..A = atoms. In every other place atom a is index `a - 1`.
        pixels: (A,) int64, pixels of each atom.
        first, second: (E,) int64 atom indices, first < second, each touching pair once, sorted.
        border_px: (E,) float64 length of the shared border, pixels.
        strength: (E,) float64 mean boundary strength along the border, 0 to 1; low = likely inside one
            object.
    """

    label: Tensor
    pixels: Tensor
    first: Tensor
    second: Tensor
    border_px: Tensor
    strength: Tensor

    def __len__(self) -> int:
        return self.pixels.shape[0]


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


def over_segment(strength: Tensor, valid: Tensor) -> Tensor:
    """Cut an image into atoms by flooding its boundary strength.

    Markers are the regional minima of the slightly blurred strength, 4-connected like the flood.

    Args:
        strength: (H, W) float64, 0 to 1.
        valid: (H, W) bool, where depth was measured.

    Returns:
        (H, W) int64, 0 = none, atoms from 1. Every atom is 4-connected and has at least `MIN_ATOM_PX` pixels.
        Together they cover the valid pixels and the small gaps between them, but for islands that are smaller
        than an atom.
    """
    area = _without_islands(without_gaps(valid))
    size = 2 * round(3 * _BLUR_PX) + 1
    blurred = gaussian_blur2d(strength[None, None], (size, size), (_BLUR_PX, _BLUR_PX))[0, 0]
    level = torch.where(area, blurred / _LEVEL, torch.inf).floor()
    # The frame of high values makes a picture without any edge one minimum, instead of none.
    minima = local_minima(F.pad(level, (1, 1, 1, 1), value=torch.inf).numpy(), connectivity=1)[1:-1, 1:-1]
    markers = components(minima & area.numpy(), connectivity=1)
    flooded = watershed(strength.numpy(), markers, mask=area.numpy(), connectivity=1)
    return absorb_small(make_atoms(torch.from_numpy(flooded).to(torch.int64), strength), MIN_ATOM_PX)


def absorb_small(atoms: Atoms, least_px: int) -> Tensor:
    """Merge parts of fewer than `least_px` pixels, the smallest first, across their weakest border.

    Of equally weak borders the longest is removed. A part without neighbours stays as it is.

    Returns:
        (H, W) int64, 0 = none, the new parts from 1.
    """
    borders = borders_between(len(atoms), atoms.first, atoms.second, atoms.border_px, atoms.strength)
    owner = torch.tensor(smallest_first(borders, atoms.pixels.tolist(), least_px), dtype=torch.int64)
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
    parts = make_atoms(_components(both), torch.zeros(both.shape, dtype=torch.float64))
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


def _components(label: Tensor) -> Tensor:
    """(H, W) int64: the 4-connected pieces of each label, from 1."""
    return torch.from_numpy(np.asarray(components(label.numpy(), connectivity=1), dtype=np.int64))


def _without_islands(mask: Tensor) -> Tensor:
    """The mask without its 4-connected pieces of fewer than `MIN_ATOM_PX` pixels."""
    pieces = _components(mask.to(torch.int64))
    large = torch.bincount(pieces.flatten()) >= MIN_ATOM_PX
    return mask & large[pieces]
