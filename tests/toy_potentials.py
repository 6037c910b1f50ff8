"""Potentials set by hand, good enough to tell a box from two: no training, the same numbers every time."""

from __future__ import annotations

from collections.abc import Sequence

import torch

from blockstab.features.merging import MERGE_COLUMNS
from blockstab.features.pairwise import PAIRWISE_COLUMNS
from blockstab.features.unary import UNARY_COLUMNS
from models.checkpoint import Potentials
from models.heads import HeadFactory, LinearHead, MLPHead, Potential, initialised


def linear(columns: Sequence[str], weights: dict[str, float], bias: float) -> Potential:
    """The sum of some features, each times its weight, and a bias."""
    head = LinearHead(len(columns))
    with torch.no_grad():
        head.linear.weight[0] = torch.tensor([weights.get(name, 0.0) for name in columns])
        head.linear.bias.fill_(bias)
    scale = torch.tensor([0.01 if "surface_distance_mean" in name else 1.0 for name in columns])
    return Potential(columns, head, torch.zeros(len(columns)), scale).requires_grad_(False)


def toy_potentials() -> Potentials:
    """Segments should fit their box and stand, neighbours be far apart; what fits one box is one object."""
    return Potentials(
        unary=linear(
            UNARY_COLUMNS, {"surface_distance_mean": 2.0, "visible_share": -1.0, "stable": -0.3}, 1.0
        ),
        pairwise=linear(PAIRWISE_COLUMNS, {"supporting": -0.5, "center_distance": -5.0}, 1.0),
        merge=linear(MERGE_COLUMNS, {"surface_distance_mean_merged": 4.0}, 0.0),
        name="toy",
        sha256="0123456789abcdef" * 4,
        provenance={},
    )


def random_potentials(head: HeadFactory = MLPHead) -> Potentials:
    """Potentials whose parameters are drawn, not learned."""
    unary, pairwise, merge = (
        Potential(
            columns,
            initialised(head, len(columns), seed),
            torch.zeros(len(columns)),
            torch.ones(len(columns)),
        )
        for seed, columns in enumerate((UNARY_COLUMNS, PAIRWISE_COLUMNS, MERGE_COLUMNS))
    )
    for potential in (unary, pairwise, merge):
        potential.requires_grad_(False)
    return Potentials(unary, pairwise, merge, "random", "0" * 64, {})
