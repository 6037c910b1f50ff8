"""Eq. 2 of the paper, as printed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import torch
from torch import Tensor

from blockstab.energy import Potential, Rating, asked
from blockstab.features.description import Described
from blockstab.proposals.search_input import SearchInput

NEUTRAL = 0.5  # between good (0) and bad (1)


@dataclass(frozen=True)
class PaperEnergy:
    """Eq. 2: the mean unary potential of the objects plus the mean pairwise potential of their boundaries.

    Background takes no part in either mean. A mean over nothing is `NEUTRAL`: were it 0, the best of all
    segmentations would be the one without a boundary, and a search would merge everything into it.

    A mean over segments rewards to merge bad ones: two bad segments that become one are one bad segment in a shorter
    list. `ExpectedOverlap` does not.

    Args:
        unary, pairwise: the potentials of segments and of boundaries.
    """

    unary: Potential
    pairwise: Potential

    def __call__(self, scenes: Sequence[Described]) -> list[Rating]:
        """Rate scenes."""
        unary = asked(self.unary, [one.unary for one in scenes])
        pairwise = asked(self.pairwise, [one.pairwise for one in scenes])
        return [
            Rating(one.scene, phi, psi, _mean(phi[~one.scene.background]) + _mean(psi))
            for one, phi, psi in zip(scenes, unary, pairwise, strict=True)
        ]


def _mean(values: Tensor) -> Tensor:
    return values.mean() if len(values) else torch.tensor(NEUTRAL, dtype=torch.float64)


class _Learned(Protocol):
    @property
    def unary(self) -> Potential: ...
    @property
    def pairwise(self) -> Potential: ...


def paper_energy(potentials: _Learned, search_input: SearchInput) -> PaperEnergy:
    """Eq. 2 with learned potentials; it is the same for every image."""
    return PaperEnergy(potentials.unary, potentials.pairwise)
