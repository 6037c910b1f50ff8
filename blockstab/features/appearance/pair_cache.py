"""Appearance of pairs of segments, measured once for all segmentations of one image that a search looks at."""

from __future__ import annotations

from collections.abc import Sequence

import torch
from torch import Tensor

from blockstab.features.appearance.contrast import contrast
from blockstab.features.appearance.pair_columns import APPEARANCE_COLUMNS, course, pooled, widened
from blockstab.features.appearance.regions import joined
from blockstab.features.appearance.unions import UnionCells
from blockstab.features.appearance.views import view
from blockstab.observation import Observation
from blockstab.segments.atoms import Atoms
from blockstab.segments.edgelets import Edgelets
from blockstab.segments.outlines import Outlines
from blockstab.segments.segmentation import Pair, Segment


class Appearances:
    """The 51 features of pairs of segments that share a border: each segment, and each pair, is measured once.

    What is said of a pair does not depend on how the rest of the image is divided. So all that surrounds the two,
    labelled or not, counts as one third region: their border is cut where either meets it, and may continue in the
    outlines that they have against it. The perimeter of a segment, to which the length of a border is relative, is
    measured along all other atoms, but not along what has no label.
    """

    def __init__(self, observation: Observation, atoms: Atoms) -> None:
        """Prepare the pixels and the cracks of all atoms."""
        self._count = len(atoms)
        self._unions = UnionCells(view(observation), atoms.label)
        self._outlines = Outlines(atoms)
        self._wide = widened(observation.boundary_map)
        self._regions = self._unions.regions(self._inside([]))
        self._perimeter = torch.empty(0, dtype=torch.float64)
        self._rows = torch.empty(0, len(APPEARANCE_COLUMNS), dtype=torch.float64)
        self._region: dict[Segment, int] = {}
        self._row: dict[frozenset[Segment], int] = {}

    def __len__(self) -> int:
        """The number of pairs measured."""
        return len(self._row)

    def __call__(self, pairs: Sequence[Pair]) -> Tensor:
        """Features of pairs, (P, 51) float64, in the order of `APPEARANCE_COLUMNS`.

        New pairs are measured in one batch. Either order of two segments gives the same.

        Raises:
            ValueError: if two segments share no border, or atoms.
        """
        keys = [frozenset(pair) for pair in pairs]
        new = {key: pair for key, pair in zip(keys, pairs, strict=True) if key not in self._row}
        if new:
            # One order of the two, so that no rounding can depend on it.
            self._measure([(a, b) if min(a) < min(b) else (b, a) for a, b in new.values()])
            start = len(self._row)
            self._row.update(zip(new, range(start, start + len(new)), strict=True))
        return self._rows[[self._row[key] for key in keys]]

    def _measure(self, pairs: list[Pair]) -> None:
        segments = list(dict.fromkeys(segment for pair in pairs for segment in pair))
        inside = self._inside(segments)
        place = {segment: i for i, segment in enumerate(segments)}
        first, second = torch.tensor([[place[a], place[b]] for a, b in pairs]).T
        _check_disjoint(pairs, inside[first] & inside[second])
        edgelets = self._outlines.edgelets(inside[first], inside[second])
        _check_bordering(pairs, edgelets)
        self._describe(segments, inside)
        index = torch.tensor([self._region[segment] for segment in segments])
        both = torch.stack([index[first], index[second]], dim=1)
        rows = course(edgelets, self._perimeter[both].flatten(), self._wide, "fixed")
        between = contrast(self._regions, both[:, 0], both[:, 1], "fixed")
        self._rows = torch.cat([self._rows, torch.cat([pooled(rows, edgelets)[2], between], dim=1)])

    def _describe(self, segments: list[Segment], inside: Tensor) -> None:
        """Measure the segments that are new, in one batch."""
        new = [i for i, segment in enumerate(segments) if segment not in self._region]
        if new:
            self._regions = joined(self._regions, self._unions.regions(inside[new]))
            self._perimeter = torch.cat([self._perimeter, self._outlines.perimeter(inside[new])])
            start = len(self._region)
            self._region.update((segments[i], start + k) for k, i in enumerate(new))

    def _inside(self, segments: Sequence[Segment]) -> Tensor:
        """(S, A + 1) bool, which atoms each segment has; the last column, for what has no label, is false."""
        inside = torch.zeros(len(segments), self._count + 1, dtype=torch.bool)
        size = torch.tensor([len(segment) for segment in segments], dtype=torch.int64)
        atoms = torch.tensor([atom for segment in segments for atom in segment], dtype=torch.int64)
        inside[torch.arange(len(segments)).repeat_interleave(size), atoms] = True
        return inside


def _check_disjoint(pairs: list[Pair], shared: Tensor) -> None:
    if bool(shared.any()):
        one, other = pairs[int(shared.any(dim=1).nonzero()[0])]
        raise ValueError(
            f"Two segments must not share atoms, but both have {sorted(one & other)}; "
            "give pairs of one segmentation."
        )


def _check_bordering(pairs: list[Pair], edgelets: Edgelets) -> None:
    apart = torch.bincount(edgelets.first // 2, minlength=len(pairs)) == 0
    if bool(apart.any()):
        one, other = pairs[int(apart.nonzero()[0])]
        raise ValueError(
            f"Two segments must share a border, but those of atoms {min(one)} and {min(other)} do not; "
            "give pairs of neighbours."
        )
