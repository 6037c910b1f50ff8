"""Overlap of segments with true objects (paper, Eq. 5)."""

from __future__ import annotations

from collections.abc import Collection, Sequence

import torch
from torch import Tensor

from blockstab.segments.atoms import Atoms
from blockstab.segments.segmentation import Segment


class Overlap:
    """The pixels that each atom shares with each true object. Unlabelled pixels do not count: a correct segment
    beside an unlabelled strip is no worse for it."""

    def __init__(self, atoms: Atoms, label: Tensor, background: Collection[int] = ()) -> None:
        """Count once for all segmentations of these atoms.

        Args:
            label: (H, W) int64 true ids, background's among them; 0 = none.
            background: ids that are no objects.
        """
        ids, index = torch.unique(label.flatten(), return_inverse=True)
        inside = (atoms.label > 0).flatten() & (label > 0).flatten()
        cells = (atoms.label.flatten()[inside] - 1) * len(ids) + index[inside]
        table = torch.bincount(cells, minlength=len(atoms) * len(ids))
        self._shared = table.view(len(atoms), len(ids)).to(torch.float64)
        self._area = torch.bincount(index, minlength=len(ids)).to(torch.float64)
        self._object = torch.tensor([i > 0 and i not in background for i in ids.tolist()])
        self._pixels = atoms.pixel_count.to(torch.float64)

    def best(self, segments: Sequence[Segment]) -> Tensor:
        """(N,) Eq. 5: the greatest intersection over union of each segment with a true object."""
        shared = self._inside(segments)
        union = shared.sum(dim=1, keepdim=True) + self._area - shared
        return torch.where(self._object, shared / union.clamp(min=1.0), 0.0).amax(dim=1)

    def thing_share(self, segments: Sequence[Segment]) -> Tensor:
        """(N,) the share of the pixels of each segment that lie on true objects."""
        on_things = self._inside(segments)[:, self._object].sum(dim=1)
        return on_things / torch.stack([self._pixels[list(s)].sum() for s in segments])

    def _inside(self, segments: Sequence[Segment]) -> Tensor:
        return torch.stack([self._shared[list(s)].sum(dim=0) for s in segments])
