"""Scenes described by hand: columns that say nothing, and potentials that are read off one of them."""

from __future__ import annotations

from collections.abc import Sequence

import torch
from torch import Tensor

from blockstab.features.columns import COLUMNS
from blockstab.features.description import Described
from blockstab.features.pairwise import neighbour_pairs
from blockstab.scene.types import Scene


def described(
    scene: Scene,
    phi: Sequence[float],
    psi: Sequence[float] | None = None,
    lost: Sequence[float] | None = None,
) -> Described:
    """The scene, its first unary and pairwise column given, all others 0."""
    unary = torch.zeros(len(scene), len(COLUMNS["unary"]), dtype=torch.float64)
    unary[:, 0] = torch.tensor(phi, dtype=torch.float64)
    pairwise = torch.zeros(len(neighbour_pairs(scene)[0]), len(COLUMNS["pairwise"]), dtype=torch.float64)
    if psi is not None:
        pairwise[:, 0] = torch.tensor(psi, dtype=torch.float64)
    share = torch.tensor(lost, dtype=torch.float64) if lost else torch.zeros(len(scene), dtype=torch.float64)
    return Described(scene, unary, pairwise, share)


def first_column(rows: Tensor) -> Tensor:
    """A potential that is the first column."""
    return rows[:, 0]
