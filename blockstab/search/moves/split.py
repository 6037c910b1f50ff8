"""Split a segment in two along its strongest border (paper, section 7.2)."""

from __future__ import annotations

from dataclasses import dataclass

import torch

from blockstab.energy import Rating
from blockstab.search.moves.drawing import draw
from blockstab.search.problem import Problem
from blockstab.segments.segmentation import Segmentation


@dataclass(frozen=True)
class Split:
    """Objects fall in two, drawn by their unary potential; never background."""

    def __call__(
        self, rating: Rating, problem: Problem, count: int, generator: torch.Generator
    ) -> list[Segmentation]:
        """At most `count` splits."""
        segmentation = rating.scene.segmentation
        possible = torch.tensor([len(s) > 1 for s in segmentation.segments]) & ~rating.scene.background
        results = []
        for index in draw(rating.unary, possible, count, generator):
            parts = problem.split(segmentation.segments[index])
            if parts is not None:
                results.append(segmentation.replace(index, parts))
        return results
