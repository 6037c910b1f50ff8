"""Random textures that fill space, as wood and stone do."""

from __future__ import annotations

import math

import torch
from torch import Tensor
from torch.nn.functional import grid_sample

_CELLS = 64  # after so many cells the texture comes again


class SolidNoise:
    """Values between -1 and 1 that change smoothly over a distance of one cell."""

    def __init__(self, generator: torch.Generator) -> None:
        """Draw the values at the corners of the cells."""
        lattice = 2.0 * torch.rand(_CELLS, _CELLS, _CELLS, generator=generator) - 1.0
        for dim in range(3):
            lattice = torch.cat([lattice, lattice.narrow(dim, 0, 1)], dim=dim)
        self._lattice = lattice[None, None]

    def __call__(self, cells: Tensor) -> Tensor:
        """The values (M,) at points (M, 3), in cells."""
        cells = cells.remainder(_CELLS)
        corner = cells.floor()
        share = cells - corner
        place = (corner + share * share * (3.0 - 2.0 * share)) * (2.0 / _CELLS) - 1.0
        return grid_sample(self._lattice, place[None, None, None], align_corners=True).flatten()


def rings(points: Tensor, spacing: Tensor, bend: Tensor) -> Tensor:
    """Growth rings of a tree whose pith runs along x beside the piece: -1 to 1, (M,).

    Args:
        points: (M, 3) metres.
        spacing: (M,) metres from ring to ring.
        bend: (M,) how far the rings are from round, in rings.
    """
    distance = torch.hypot(points[:, 1] + 7.3 * spacing, points[:, 2] - 11.9 * spacing)
    return (2 * math.pi * (distance / spacing + bend)).sin()
