"""Edge models: from the cues of an edge to the strength of boundaries between objects."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import torch
from torch import Tensor

from blockstab.boundaries import BoundaryMap
from blockstab.boundaries.cues import CUES, Cues
from blockstab.boundaries.gradients import COLOR_GRADIENTS, pb


class EdgeModel(Protocol):
    """A way to weigh the cues of an edge: a class with its settings."""

    def __call__(self, cues: Cues, /) -> BoundaryMap:
        """The strength of boundaries; each pixel by itself."""


@dataclass(frozen=True)
class FixedWeights:
    """The strongest of: a jump of depth, a concave crease, the rim of missing depth, an edge of colour.

    Creases are concave where one thing stands on another or leans against it. In convex ones the faces of one box
    meet, so they do not count (Gupta et al. 2013; Stein et al. 2014, "Object partitioning using local convexity").

    Args:
        color_share: of the probability of an edge of colour or texture (`pb`). Printed boxes have strong ones: alone,
            they must not outweigh geometry, but they order what lies inside one object.
    """

    color_share: float = 0.3

    def __post_init__(self) -> None:
        if not 0.0 <= self.color_share <= 1.0:
            raise ValueError(
                f"The share of colour must lie between 0 and 1, but it is {self.color_share}; correct it."
            )

    def __call__(self, cues: Cues) -> BoundaryMap:
        """Combine."""
        oriented = self.color_share * pb(cues.values[: len(COLOR_GRADIENTS)])
        for name in ("depth", "concave", "rim"):
            oriented = torch.maximum(oriented, cues[name])
        return _map(oriented)


@dataclass(frozen=True)
class LogisticWeights:
    """The logistic function of a weighted sum, as fitted to true boundaries.

    Args:
        weights: one for each of `CUES`, in their order.
        bias: added to the sum.
    """

    weights: Sequence[float]
    bias: float

    def __post_init__(self) -> None:
        if len(self.weights) != len(CUES):
            raise ValueError(
                f"There must be a weight for each of {', '.join(CUES)}, but there are {len(self.weights)}; "
                "train them anew."
            )

    def __call__(self, cues: Cues) -> BoundaryMap:
        """Combine."""
        logit = torch.full_like(cues.values[0], self.bias)
        for cue, weight in zip(cues.values, self.weights, strict=True):
            logit.add_(cue, alpha=weight)
        # Unlike `sigmoid`, this rounds every pixel in the same way, whichever thread it falls to.
        return _map(logit.neg_().exp_().add_(1.0).reciprocal_())


def _map(oriented: Tensor) -> BoundaryMap:
    oriented = oriented.double()
    return BoundaryMap(oriented, oriented.amax(dim=0))
