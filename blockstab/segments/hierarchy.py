"""In which order atoms merge into larger and larger parts, and how a segment falls in two."""

from __future__ import annotations

from dataclasses import dataclass

import torch
import torch.nn.functional as F
from torch import Tensor

from blockstab.segments.atoms import Atoms
from blockstab.segments.contraction import Borders, borders_between, lowest_first
from blockstab.segments.segmentation import Segment, Segmentation


@dataclass(frozen=True)
class Hierarchy:
    """The borders between atoms, and the order in which merging across the weakest one removes them.

    Args:
        borders: before any merge.
        first, second: (M,) int64 the parts of each merge, named by their smallest atoms, first < second.
        height: (M,) float64 mean strength of the border that goes, and no less than any before it.
    """

    borders: Borders
    first: Tensor
    second: Tensor
    height: Tensor

    def cut(self, threshold: float) -> Segmentation:
        """The parts that merges of height up to `threshold` make."""
        parts = {atom: {atom} for atom in self.borders}
        done = self.height <= threshold
        for kept, gone in zip(self.first[done].tolist(), self.second[done].tolist(), strict=True):
            parts[kept] |= parts.pop(gone)
        return Segmentation(tuple(frozenset(parts[atom]) for atom in sorted(parts)))


def build_hierarchy(atoms: Atoms) -> Hierarchy:
    """Merge atoms until no border is left; the strength of a merged border is the mean along its length."""
    borders = borders_between(len(atoms), atoms.first, atoms.second, atoms.border_px, atoms.strength)
    merges = list(lowest_first({atom: dict(row) for atom, row in borders.items()}))
    order = torch.tensor([(kept, gone) for kept, gone, _ in merges], dtype=torch.int64).view(-1, 2)
    mean = torch.tensor([mean for _, _, mean in merges], dtype=torch.float64)
    return Hierarchy(borders, order[:, 0], order[:, 1], mean.cummax(dim=0).values if merges else mean)


def split(segment: Segment, atoms: Atoms, hierarchy: Hierarchy) -> tuple[Segment, Segment] | None:
    """Divide a segment along the strongest border within it (paper, section 7.2).

    Its borders are removed from the weakest to the strongest until two parts remain. Only borders inside the
    segment take part, so the answer does not depend on what surrounds it; for a part of the hierarchy it is
    the two parts that the hierarchy made it from. Pieces that do not touch stay whole; while there are more
    than two, the two whose centroids in the image are nearest are joined.

    Returns:
        The part with the smallest atom, and the other; None for a single atom.
    """
    if len(segment) < 2:
        return None
    parts = {atom: {atom} for atom in sorted(segment)}
    inner = {i: {j: b for j, b in hierarchy.borders[i].items() if j in segment} for i in parts}
    for kept, gone, _ in lowest_first(inner):
        if len(parts) == 2:
            break
        parts[kept] |= parts.pop(gone)
    while len(parts) > 2:
        kept, gone = _nearest(list(parts.values()), atoms)
        names = list(parts)
        parts[names[kept]] |= parts.pop(names[gone])
    one, other = (frozenset(part) for part in parts.values())
    return one, other


def _nearest(parts: list[set[int]], atoms: Atoms) -> tuple[int, int]:
    """The two parts with the nearest pixel centroids, in order; the first pair of equals."""
    part_of = torch.zeros(len(atoms), dtype=torch.int64)
    for number, part in enumerate(parts, start=1):
        part_of[list(part)] = number
    part_of_pixel = F.pad(part_of, (1, 0))[atoms.label]
    pixels = part_of_pixel.nonzero()
    number_of = part_of_pixel[part_of_pixel > 0] - 1
    sums = torch.zeros(len(parts), 2, dtype=torch.float64).index_add_(0, number_of, pixels.double())
    centroids = sums / torch.bincount(number_of)[:, None]
    first, second = torch.triu_indices(len(parts), len(parts), offset=1)
    nearest = int((centroids[first] - centroids[second]).norm(dim=1).argmin())
    return int(first[nearest]), int(second[nearest])
