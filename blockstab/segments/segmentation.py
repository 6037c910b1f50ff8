"""Segmentations: sets of atoms, never changed in place."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from itertools import chain

import torch
import torch.nn.functional as F
from torch import Tensor

from blockstab.segments.atoms import Atoms

Segment = frozenset[int]  # atom indices
Pair = tuple[Segment, Segment]

NEIGHBOUR_PX = 5  # segments that share less border are no neighbours


@dataclass(frozen=True)
class Segmentation:
    """A partition of the atoms.

    Args:
        segments: disjoint non-empty sets of atom indices, sorted by their smallest atom, so that equal
            partitions are equal values and hash alike.
    """

    segments: tuple[Segment, ...]

    def __len__(self) -> int:
        return len(self.segments)

    @classmethod
    def from_labels(cls, atoms: Atoms, label: Tensor) -> Segmentation:
        """Gather the atoms by the label that most of their pixels have, the smallest of equals.

        Args:
            label: (H, W) int64; atoms whose label is 0 belong to no segment.
        """
        if label.shape != atoms.label.shape:
            raise ValueError(
                f"Labels must have the size of the atoms, {tuple(atoms.label.shape)}, but they have "
                f"{tuple(label.shape)}; compute both from the same image."
            )
        ids, index = torch.unique(label, return_inverse=True)
        inside = atoms.label > 0
        cells = (atoms.label[inside] - 1) * len(ids) + index[inside]
        votes = torch.bincount(cells, minlength=len(atoms) * len(ids)).view(len(atoms), len(ids))
        gathered: dict[int, list[int]] = {}
        for atom, region in enumerate(ids[votes.argmax(dim=1)].tolist() if len(atoms) else []):
            if region > 0:
                gathered.setdefault(region, []).append(atom)
        return cls(_in_order(map(frozenset, gathered.values())))

    def merge(self, i: int, j: int) -> Segmentation:
        """Segments i and j become one."""
        if i == j:
            raise ValueError(f"A merge needs two segments, but both are {i}; choose another.")
        rest = [s for k, s in enumerate(self.segments) if k not in (i, j)]
        return Segmentation(_in_order([*rest, self.segments[i] | self.segments[j]]))

    def replace(self, i: int, parts: Iterable[Segment]) -> Segmentation:
        """Segment i falls into `parts`, which must be disjoint, not empty, and make it up."""
        parts = list(parts)
        whole = self.segments[i]
        if not all(parts) or frozenset().union(*parts) != whole or sum(map(len, parts)) != len(whole):
            raise ValueError(
                f"Parts must divide the atoms of segment {i}, {sorted(whole)}, but they are "
                f"{[sorted(part) for part in parts]}; give each of its atoms to one part."
            )
        return Segmentation(_in_order([*self.segments[:i], *self.segments[i + 1 :], *parts]))

    def index_of_atom(self, count: int) -> Tensor:
        """(count,) int64: the segment of each of `count` atoms; -1 where it belongs to none."""
        index = torch.full((count,), -1)
        sizes = torch.tensor([len(s) for s in self.segments], dtype=torch.int64)
        members = torch.tensor(list(chain.from_iterable(self.segments)), dtype=torch.int64)
        index[members] = torch.arange(len(self)).repeat_interleave(sizes)
        return index

    def labels(self, atoms: Atoms) -> Tensor:
        """(H, W) int64 label image: segment k has label k + 1, what belongs to none has 0."""
        return F.pad(self.index_of_atom(len(atoms)) + 1, (1, 0))[atoms.label]

    def neighbours(self, atoms: Atoms, min_border_px: int = NEIGHBOUR_PX) -> tuple[Tensor, Tensor]:
        """Pairs of segments that share at least `min_border_px` pixels of border.

        Returns:
            (P,) and (P,) int64 segment indices, the smaller first, sorted.
        """
        index = self.index_of_atom(len(atoms))
        a, b = index[atoms.first], index[atoms.second]
        border = (a != b) & (a >= 0) & (b >= 0)
        pair = torch.minimum(a, b)[border] * len(self) + torch.maximum(a, b)[border]
        pairs, place = torch.unique(pair, return_inverse=True)
        shared = torch.bincount(place, atoms.border_px[border], minlength=len(pairs))
        pairs = pairs[shared >= min_border_px]
        return pairs // max(len(self), 1), pairs % max(len(self), 1)


def _in_order(segments: Iterable[Segment]) -> tuple[Segment, ...]:
    return tuple(sorted(segments, key=min))
