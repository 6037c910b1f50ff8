"""Energies of segmentations. An energy is any callable of the shape `Energy`; lower is better."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Protocol

import torch
from torch import Tensor

from blockstab.features.description import Described
from blockstab.scene.types import Scene

Potential = Callable[[Tensor], Tensor]  # rows of features to potentials (N,); lower is better


@dataclass(frozen=True)
class Rating:
    """A scene and what the energy says of it; lower is better throughout.

    Args:
        scene: N segments.
        unary: (N,) potential of each segment, background too.
        pairwise: (M,) potential of each pair of `neighbour_pairs(scene)`.
        energy: 0-d; it carries a gradient where the potentials do.
    """

    scene: Scene
    unary: Tensor
    pairwise: Tensor
    energy: Tensor


class Energy(Protocol):
    """Rates scenes."""

    def __call__(self, scenes: Sequence[Described], /) -> list[Rating]:
        """Rate scenes; a scene's rating does not depend on which others are rated with it, but for rounding."""


def asked(potential: Potential, parts: Sequence[Tensor]) -> tuple[Tensor, ...]:
    """The potentials of the rows of each part, asked for together; rows that are alike, once."""
    if not parts:
        return ()
    rows = torch.cat(list(parts))
    first = dict[bytes, int]()
    alike = [first.setdefault(row.tobytes(), i) for i, row in enumerate(rows.detach().numpy())]
    once, of_each = torch.unique(torch.tensor(alike, dtype=torch.int64), return_inverse=True)
    return torch.split(potential(rows[once])[of_each], [len(part) for part in parts])
