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


def nodes(hierarchy: Hierarchy) -> list[Segment]:
    """Every part that ever exists while atoms merge, the atoms among them, in the order in which they come about."""
    part = {atom: frozenset({atom}) for atom in hierarchy.borders}
    found = list(part.values())
    for kept, gone in zip(hierarchy.first.tolist(), hierarchy.second.tolist(), strict=True):
        part[kept] |= part.pop(gone)
        found.append(part[kept])
    return found


def joined_at(hierarchy: Hierarchy, first: Tensor, second: Tensor) -> Tensor:
    """The height at which two atoms become one part.

    Args:
        first, second: (E,) int64 atom indices; pair e is `first[e]`, `second[e]`.

    Returns:
        (E,) float64; 0 for an atom and itself, infinite where no merge joins the two.
    """
    merges, atoms = len(hierarchy.height), len(hierarchy.borders)
    # Every merge takes the name of one part away: follow each atom's name, earliest merge first, until the two agree.
    gone_in, name = torch.full((atoms,), merges), torch.arange(atoms)
    gone_in[hierarchy.second], name[hierarchy.second] = torch.arange(merges), hierarchy.first
    height = torch.cat([hierarchy.height, hierarchy.height.new_tensor([torch.inf, 0.0])])
    last = torch.full_like(first, -1)
    while bool((apart := first != second).any()):
        swap = gone_in[first] > gone_in[second]
        first, second = torch.where(swap, second, first), torch.where(swap, first, second)
        last = torch.where(apart, gone_in[first], last)
        first = torch.where(gone_in[first] == merges, second, torch.where(apart, name[first], first))
    return height[last]


def ultrametric_map(hierarchy: Hierarchy, atoms: Atoms) -> Tensor:
    """The hierarchy as an image of its boundaries (Arbelaez et al. 2011), in double size.

    Pixel (r, c) of the image is at (2 r + 1, 2 c + 1), and the crack between it and its right neighbour at
    (2 r + 1, 2 c + 2). A crack has the height at which the atoms on its two sides become one part, 0 inside an atom;
    a corner has that of its highest crack. What has no atom is 1, and so are cracks beside it and the image's rim.

    Args:
        hierarchy: of the atoms.
        atoms: each 4-connected, so that every part is.

    Returns:
        (2 H + 1, 2 W + 1) float64, 0 to 1. For any threshold below 1, the 4-connected pieces of what is not above it
        are the segments of `hierarchy.cut(threshold)`.
    """
    rows, columns = atoms.label.shape
    image = torch.ones(2 * rows + 1, 2 * columns + 1, dtype=torch.float64)
    image[1::2, 1::2] = (atoms.label == 0).double()
    image[1::2, 2:-1:2] = _crack_heights(hierarchy, atoms.label[:, :-1], atoms.label[:, 1:])
    image[2:-1:2, 1::2] = _crack_heights(hierarchy, atoms.label[:-1], atoms.label[1:])
    beside = torch.maximum(image[2:-1:2, 1:-2:2], image[2:-1:2, 3::2])
    image[2:-1:2, 2:-1:2] = beside.maximum(image[1:-2:2, 2:-1:2]).maximum(image[3::2, 2:-1:2])
    return image


def _crack_heights(hierarchy: Hierarchy, one: Tensor, other: Tensor) -> Tensor:
    """The heights of cracks between atoms of labels `one` and `other`, of any shape; 1 where one of them is none."""
    height = torch.ones_like(one, dtype=torch.float64)
    inner = (one > 0) & (other > 0)
    sides = torch.stack([one[inner], other[inner]]) - 1
    pairs, place = torch.unique(sides, dim=1, return_inverse=True)
    height[inner] = joined_at(hierarchy, *pairs)[place]
    return height


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
