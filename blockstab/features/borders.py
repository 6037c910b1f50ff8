"""Borders of atoms: cues of an edge, which side is nearer, and where the image ends."""

from __future__ import annotations

from dataclasses import dataclass

import torch
from torch import Tensor

from blockstab.boundaries.cues import CUES
from blockstab.observation import Observation
from blockstab.rgbd.noise import DepthNoise
from blockstab.segments.atoms import Atoms
from blockstab.segments.edgelets import cracks_of

BORDER_CUES = ("strength", "brightness", "color", "texture", "depth", "convex", "concave")
_SOURCES = ("brightness", ("color_a", "color_b"), "texture", "depth", "convex", "concave")
_STEP = (0.01, 2.0)  # metres and sensor steps, the larger: what is nearer by more lies before the other


@dataclass(frozen=True)
class AtomBorders:
    """The E borders between A atoms.

    Args:
        cues: (E, 7) float64 sums along each border, in the order of `BORDER_CUES`.
        front: (E, 2) float64 pixels of border along which the first atom lies before the second, and behind it.
        open: (A, 2) float64 pixels of each atom's outline beside what has no label, and at the image's rim.
    """

    cues: Tensor
    front: Tensor
    open: Tensor

    @staticmethod
    def of(observation: Observation, atoms: Atoms) -> AtomBorders:
        """Measure every border once."""
        count = len(atoms)
        cracks = cracks_of(atoms.label)
        between = (cracks.regions >= 0).all(dim=1)
        beside = cracks.regions[~between].amax(dim=1)
        blank = torch.bincount(beside[beside >= 0], minlength=count)
        rim = torch.bincount(_rim(atoms.label) - 1, minlength=count)
        pixels, regions = cracks.pixels[between], cracks.regions[between]
        swapped = regions[:, 0] > regions[:, 1]
        pixels = torch.where(swapped[:, None, None], pixels.flip(1), pixels)
        ends = regions.sort(dim=1).values
        border = torch.searchsorted(
            atoms.first * count + atoms.second, ends[:, 0].contiguous() * count + ends[:, 1]
        )
        row, column = pixels.unbind(dim=-1)
        along = _maps(observation)[:, row, column].amax(dim=2).T.double()
        before = _before(observation.cloud.depth[row, column], observation.cloud.noise)
        zeros = torch.zeros(len(atoms.first), len(BORDER_CUES) + 2, dtype=torch.float64)
        sums = zeros.index_add(0, border, torch.cat([along, before], dim=1))
        return AtomBorders(sums[:, :-2], sums[:, -2:], torch.stack([blank, rim], dim=1).double())


def _maps(observation: Observation) -> Tensor:
    """(7, H, W) the images of `BORDER_CUES`."""
    cues = [
        observation.cues[
            [CUES.index(name) for name in ((source,) if isinstance(source, str) else source)]
        ].amax(dim=0)
        for source in _SOURCES
    ]
    return torch.stack([observation.boundary_map.strength, *(sign.double() for sign in cues)])


def _before(depth: Tensor, noise: DepthNoise) -> Tensor:
    """(K, 2) float64, whether the first side of a crack lies before the second, and behind it; depth is (K, 2)."""
    near, far = depth.unbind(dim=1)
    known = (depth > 0).all(dim=1)
    step = (_STEP[1] * noise.at(depth.amax(dim=1).square())).clamp(min=_STEP[0])
    return torch.stack([known & (far - near > step), known & (near - far > step)], dim=1).double()


def _rim(label: Tensor) -> Tensor:
    """The labels of the pixels at the image's rim, one for each of its sides there."""
    sides = torch.cat([label[0], label[-1], label[:, 0], label[:, -1]])
    return sides[sides > 0]
