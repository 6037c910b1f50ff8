"""Segmentations: sets of atoms, never changed in place."""

from __future__ import annotations

from dataclasses import dataclass

Segment = frozenset[int]  # atom indices


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
