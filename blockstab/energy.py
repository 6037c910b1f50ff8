"""How good a segmentation is: Eq. 2 of the paper, from any two potentials."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import torch
from torch import Tensor

from blockstab.features.pairwise import pairwise_features
from blockstab.features.unary import unary_features
from blockstab.scene import Scene

Potential = Callable[[Tensor], Tensor]  # features (N, F) to potentials (N,); lower is better


@dataclass(frozen=True)
class Rating:
    """A scene and what the energy says of it; lower is better throughout.

    Args:
        unary: (N,) potential of each segment, background too.
        pairwise: (M,) potential of each pair of `boundaries(scene)`.
        energy: Eq. 2.
    """

    scene: Scene
    unary: Tensor
    pairwise: Tensor
    energy: float


@dataclass(frozen=True)
class Energy:
    """E(S): the mean unary potential of the objects plus the mean pairwise potential of their boundaries (Eq. 2).

    Background takes no part in either mean. A mean over nothing is 0.
    """

    unary: Potential
    pairwise: Potential

    def __call__(self, scenes: Sequence[Scene]) -> list[Rating]:
        """Rate scenes; each potential is asked once for all of them."""
        if not scenes:
            return []
        rows = [unary_features(scene) for scene in scenes]
        pair_rows = [pairwise_features(scene) for scene in scenes]
        unary = self.unary(torch.cat(rows)).split([len(r) for r in rows])
        pairwise = self.pairwise(torch.cat(pair_rows)).split([len(r) for r in pair_rows])
        return [
            Rating(scene, phi, psi, _mean(phi[~scene.background]) + _mean(psi))
            for scene, phi, psi in zip(scenes, unary, pairwise, strict=True)
        ]


def _mean(values: Tensor) -> float:
    return float(values.mean()) if len(values) else 0.0
