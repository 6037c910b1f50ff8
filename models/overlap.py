"""How well segments cover true objects (paper, Eq. 5)."""

from __future__ import annotations

import torch
from torch import Tensor

from blockstab.segments.atoms import Atoms
from blockstab.segments.segmentation import Segment, Segmentation


class Overlap:
    """The pixels that each atom shares with each true object. Unlabelled pixels do not count: a correct segment
    beside an unlabelled strip is no worse for it."""

    def __init__(self, atoms: Atoms, label: Tensor) -> None:
        """Count once for all segmentations of these atoms.

        Args:
            label: (H, W) int64 true ids, background's among them; 0 = none.
        """
        self._ids, index = label.flatten().unique(return_inverse=True)
        inside = (atoms.label > 0).flatten() & (label > 0).flatten()
        cells = (atoms.label.flatten()[inside] - 1) * len(self._ids) + index[inside]
        table = torch.bincount(cells, minlength=len(atoms) * len(self._ids))
        self._shared = table.view(len(atoms), len(self._ids)).to(torch.float64)
        self._area = torch.bincount(index, minlength=len(self._ids)).to(torch.float64)

    def best(self, segmentation: Segmentation) -> Tensor:
        """(N,) Eq. 5: the greatest intersection over union of each segment with a true region."""
        shared = torch.stack([self._shared[list(s)].sum(dim=0) for s in segmentation.segments])
        union = shared.sum(dim=1, keepdim=True) + self._area - shared
        return (shared / union.clamp(min=1.0)).amax(dim=1)

    def owner(self, segment: Segment) -> int:
        """The true id with most pixels in the segment; 0 where it has no labelled pixel."""
        shared = self._shared[list(segment)].sum(dim=0)
        return int(self._ids[shared.argmax()]) if float(shared.sum()) > 0 else 0
