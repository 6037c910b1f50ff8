"""Ways to look for the segmentation of least energy. A search is any callable of the shape `Search`."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import torch

from blockstab.energy import Rating
from blockstab.search.problem import Problem
from blockstab.segments.segmentation import Segmentation

_DIGITS = 9  # of an energy that count: further ones may hang on the processor, and on what is rated beside


def rank(rating: Rating) -> float:
    """The energy as searches compare it.

    Everything that a search decides by comparing energies or potentials goes by values rounded here, so that what
    rounds differently in another batch does not turn it.
    """
    return round(float(rating.energy.detach()), _DIGITS)


@dataclass(frozen=True)
class SearchResult:
    """Result of a search.

    Args:
        best: its best scene.
        trace: the energy of the best it kept after each step.
        bests: the segmentation of each step; as many as the trace has.
    """

    best: Rating
    trace: tuple[float, ...]
    bests: tuple[Segmentation, ...]

    @staticmethod
    def of(ratings: Sequence[Rating]) -> SearchResult:
        """From the best after each step, the last of which is the result."""
        return SearchResult(
            ratings[-1], tuple(rank(one) for one in ratings), tuple(one.scene.segmentation for one in ratings)
        )


class Search(Protocol):
    """From a segmentation to a better one."""

    def __call__(self, start: Segmentation, problem: Problem, generator: torch.Generator) -> SearchResult: ...
