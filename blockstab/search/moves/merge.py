"""Merge two neighbours (paper, section 7.2)."""

from __future__ import annotations

from dataclasses import dataclass

import torch

from blockstab.energy import Rating
from blockstab.features.pairwise import neighbour_pairs
from blockstab.search.moves.drawing import draw
from blockstab.search.problem import Problem
from blockstab.segments.segmentation import Segmentation


@dataclass(frozen=True)
class Merge:
    """Neighbouring objects become one, drawn by the pairwise potential of their boundary; never background."""

    def __call__(
        self, rating: Rating, problem: Problem, count: int, generator: torch.Generator
    ) -> list[Segmentation]:
        """At most `count` merges."""
        first, second = neighbour_pairs(rating.scene)
        possible = torch.ones(len(first), dtype=torch.bool)
        drawn = draw(rating.pairwise, possible, count, generator)
        return [rating.scene.segmentation.merge(int(first[k]), int(second[k])) for k in drawn]
