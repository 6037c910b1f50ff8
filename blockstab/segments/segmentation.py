"""Segmentations: sets of atoms, never changed in place."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cached_property
from itertools import chain

import numpy as np
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
        told: segments of which it is known whether they are background, with the answer; what nobody has told is
            found out from the segment's box.
    """

    segments: tuple[Segment, ...]
    told: frozenset[tuple[Segment, bool]] = frozenset()

    def __len__(self) -> int:
        return len(self.segments)

    @cached_property
    def background(self) -> dict[Segment, bool]:
        """Of the segments that something was told of: whether they are background."""
        return dict(self.told)

    def telling(self, told: Mapping[Segment, bool]) -> Segmentation:
        """The same segments, and what is told of some of them, in place of what was told before."""
        known = {**self.background, **told}
        kept = set(self.segments)
        return Segmentation(self.segments, frozenset((s, b) for s, b in known.items() if s in kept))

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
        """Segments i and j become one; what was told of both alike is told of it."""
        if i == j:
            raise ValueError(f"A merge needs two segments, but both are {i}; choose another.")
        one, other = self.segments[i], self.segments[j]
        rest = [s for k, s in enumerate(self.segments) if k not in (i, j)]
        told = self.background.get(one)
        agreed = {one | other: told} if told is not None and told == self.background.get(other) else {}
        return Segmentation(_in_order([*rest, one | other]), self.told).telling(agreed)

    def replace(self, i: int, parts: Iterable[Segment]) -> Segmentation:
        """Segment i falls into `parts`, which must be disjoint, not empty, and make it up; what was told stays."""
        parts = list(parts)
        whole = self.segments[i]
        if not all(parts) or frozenset().union(*parts) != whole or sum(map(len, parts)) != len(whole):
            raise ValueError(
                f"Parts must divide the atoms of segment {i}, {sorted(whole)}, but they are "
                f"{[sorted(part) for part in parts]}; give each of its atoms to one part."
            )
        told = dict.fromkeys(parts, self.background[whole]) if whole in self.background else {}
        return Segmentation(
            _in_order([*self.segments[:i], *self.segments[i + 1 :], *parts]), self.told
        ).telling(told)

    def carve(self, mask: Segment) -> Segmentation:
        """`mask` becomes an object; segments that hold a part of it lose that part, or go."""
        rest, told = [], {mask: False}
        for segment in self.segments:
            left = segment - mask
            if left:
                rest.append(left)
            if left and segment in self.background:
                told[left] = self.background[segment]
        return Segmentation(_in_order([*rest, mask]), self.told).telling(told)

    def index_of_atom(self, count: int) -> Tensor:
        """(count,) int64: the segment of each of `count` atoms; -1 where it belongs to none."""
        index = np.full(count, -1)
        members = np.fromiter(chain.from_iterable(self.segments), dtype=np.int64)
        index[members] = np.arange(len(self)).repeat([len(s) for s in self.segments])
        return torch.from_numpy(index)

    def labels(self, atoms: Atoms) -> Tensor:
        """(H, W) int64 label image: segment k has label k + 1, what belongs to none has 0."""
        return F.pad(self.index_of_atom(len(atoms)) + 1, (1, 0))[atoms.label]

    def neighbours(self, atoms: Atoms, min_border_px: int = NEIGHBOUR_PX) -> tuple[Tensor, Tensor]:
        """Pairs of segments that share at least `min_border_px` pixels of border.

        Returns:
            (P,) and (P,) int64 segment indices, the smaller first, sorted.
        """
        index, n = self.index_of_atom(len(atoms)).numpy(), len(self)
        a, b = index[atoms.first.numpy()], index[atoms.second.numpy()]
        border = (a != b) & (a >= 0) & (b >= 0)
        pair = (np.minimum(a, b) * n + np.maximum(a, b))[border]
        # A table of all pairs, for most of a scene's few segments border on each other anyhow.
        shared = np.bincount(pair, atoms.border_px.numpy()[border], minlength=n * n).reshape(n, n)
        touching = np.bincount(pair, minlength=n * n).reshape(n, n) > 0
        first, second = (touching & (shared >= min_border_px)).nonzero()
        return torch.from_numpy(first), torch.from_numpy(second)


def _in_order(segments: Iterable[Segment]) -> tuple[Segment, ...]:
    return tuple(sorted(segments, key=min))
