"""Potentials set by hand, good enough to tell a box from two: no training, the same numbers every time."""

from __future__ import annotations

from collections.abc import Sequence

import torch

from blockstab.features.columns import COLUMNS
from models.potentials.checkpoint import Potentials
from models.potentials.heads import HeadFactory, LinearHead, MLPHead, Potential, initialised


def linear(columns: Sequence[str], weights: dict[str, float], bias: float) -> Potential:
    """The sum of some features, each times its weight, and a bias."""
    head = LinearHead(len(columns))
    with torch.no_grad():
        head.linear.weight[0] = torch.tensor([weights.get(name, 0.0) for name in columns])
        head.linear.bias.fill_(bias)
    scale = torch.tensor([0.01 if "surface_distance_mean" in name else 1.0 for name in columns])
    return Potential(columns, head, torch.zeros(len(columns)), scale).requires_grad_(False)


def toy_potentials() -> Potentials:
    """Segments should fit their box and stand, neighbours be far apart; what lies before all is a thing."""
    return Potentials(
        unary=linear(
            COLUMNS["unary"], {"surface_distance_mean": 2.0, "visible_share": -1.0, "stable": -0.3}, 1.4
        ),
        pairwise=linear(COLUMNS["pairwise"], {"supporting": -0.5, "center_distance": -5.0}, 1.0),
        alone=linear(
            COLUMNS["alone"],
            {"outline_before_share": -0.8, "interior_convex": -0.4, "interior_concave": 2.0},
            0.9,
        ),
        background=linear(COLUMNS["background"], {"ground_share": -1.0}, 1.0),
        weight=0.1,
        name="toy",
        sha256="0123456789abcdef" * 4,
        provenance={},
    )


def kinds_of(potentials: Potentials, **changed: Potential) -> dict[str, Potential]:
    """The potentials by kind, as `save_potentials` takes them, some of them replaced."""
    return {kind: getattr(potentials, kind) for kind in COLUMNS} | changed


def random_potentials(head: HeadFactory = MLPHead) -> Potentials:
    """Potentials whose parameters are drawn, not learned."""
    kinds = {
        kind: Potential(
            columns,
            initialised(head, len(columns), seed),
            torch.zeros(len(columns)),
            torch.ones(len(columns)),
        ).requires_grad_(False)
        for seed, (kind, columns) in enumerate(COLUMNS.items())
    }
    return Potentials(**kinds, weight=0.1, name="random", sha256="0" * 64, provenance={})
