"""The finest partition of an image: every segment is a set of atoms."""

from __future__ import annotations

from dataclasses import dataclass

from torch import Tensor


@dataclass(frozen=True)
class Atoms:
    """A partition of the labelled pixels, and which parts touch.

    Args:
        label: (H, W) int64; 0 = no atom, 1..A = atoms. In every other place atom a is index `a - 1`.
        pixels: (A,) int64, pixels of each atom.
        first, second: (E,) int64 atom indices, first < second, each touching pair once, sorted.
        border_px: (E,) float64 length of the shared border, pixels.
        strength: (E,) float64 mean boundary strength along the border, 0 to 1; low = likely inside one object.
    """

    label: Tensor
    pixels: Tensor
    first: Tensor
    second: Tensor
    border_px: Tensor
    strength: Tensor

    def __len__(self) -> int:
        return self.pixels.shape[0]
