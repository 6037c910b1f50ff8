"""The score `overlap` of many segmentations of one image, without painting them."""

from __future__ import annotations

from collections.abc import Sequence

import torch
from torch import Tensor

from blockstab.segments.atoms import Atoms
from blockstab.segments.segmentation import Segmentation


class OverlapOfAtoms:
    """`overlap_score` of a segmentation's label image, from the pixels that each atom shares with each object."""

    def __init__(self, atoms: Atoms, label: Tensor, objects: Sequence[int]) -> None:
        """Count once for all segmentations of these atoms.

        Args:
            label: (H, W) int64 true ids.
            objects: the ids that are scored, at least one.
        """
        inside = [atoms.label[(label == identity) & (atoms.label > 0)] - 1 for identity in objects]
        self._shared = torch.stack([torch.bincount(some, minlength=len(atoms)) for some in inside], dim=1)
        self._area = torch.stack([(label == identity).sum() for identity in objects])
        self._pixels = atoms.pixel_count

    def __call__(self, segmentation: Segmentation) -> float:
        """Between 0 and 1."""
        index = segmentation.index_of_atom(len(self._pixels))
        held = index >= 0
        shared = self._shared.new_zeros(len(segmentation), len(self._area))
        shared = shared.index_add(0, index[held], self._shared[held])
        pixels = self._pixels.new_zeros(len(segmentation)).index_add(0, index[held], self._pixels[held])
        union = pixels[:, None] + self._area - shared
        best = (shared.double() / union).amax(dim=0)
        return float((self._area * best).sum() / self._area.sum())
