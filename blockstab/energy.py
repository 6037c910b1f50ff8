"""How good a segmentation is: Eq. 2 of the paper, from any two potentials."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import chain

import torch
from torch import Tensor
from torch.nn.functional import pad

from blockstab.features.pairwise import pairs_of, pairwise_features
from blockstab.features.unary import unary_features
from blockstab.scene import Scene
from blockstab.segments.segmentation import Pair

NEUTRAL = 0.5  # between good (0) and bad (1)

Potential = Callable[[Tensor], Tensor]  # features (N, F) to potentials (N,); lower is better
Appearance = Callable[[Sequence[Pair]], Tensor]  # P bordering pairs to (P, 51) features of how they look

_BLOCK = 64  # rows that a potential is asked for at a time


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
    """Eq. 2: the mean unary potential of the objects plus the mean pairwise potential of their boundaries.

    Background takes no part in either mean. A mean over nothing is `NEUTRAL`: were it 0, the best of all
    segmentations would be the one without a boundary, and a search would merge everything into it.

    Args:
        unary, pairwise: the potentials of segments and of boundaries.
        appearance: how pairs of segments of the image look, see `Appearances`.
    """

    unary: Potential
    pairwise: Potential
    appearance: Appearance

    def __call__(self, scenes: Sequence[Scene]) -> list[Rating]:
        """Rate scenes; a scene's rating does not depend on which others are rated with it.

        What is new of their boundaries is looked at in one batch.
        """
        if not scenes:
            return []
        unary = _asked(self.unary, [unary_features(scene) for scene in scenes])
        pairwise = _asked(self.pairwise, self._boundaries(scenes))
        return [
            Rating(scene, phi, psi, _mean(phi[~scene.background]) + _mean(psi))
            for scene, phi, psi in zip(scenes, unary, pairwise, strict=True)
        ]

    def _boundaries(self, scenes: Sequence[Scene]) -> list[Tensor]:
        """The pairwise features of each scene."""
        pairs = [pairs_of(scene) for scene in scenes]
        looks = torch.split(self.appearance(list(chain(*pairs))), [len(some) for some in pairs])
        return [pairwise_features(scene, look) for scene, look in zip(scenes, looks, strict=True)]


def _asked(potential: Potential, parts: Sequence[Tensor]) -> tuple[Tensor, ...]:
    """The potentials of the rows of each part, asked for together.

    A matrix product rounds a row differently when it stands among few others, so the rows are asked for in
    blocks of one size, the last of them filled up.
    """
    rows = torch.cat(list(parts))
    blocks = torch.split(pad(rows, (0, 0, 0, -len(rows) % _BLOCK)), _BLOCK)
    values = torch.cat([potential(block) for block in blocks])
    return torch.split(values[: len(rows)], [len(part) for part in parts])


def _mean(values: Tensor) -> float:
    return float(values.mean()) if len(values) else NEUTRAL
