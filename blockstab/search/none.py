"""No search: the segmentation is understood as it is."""

from __future__ import annotations

from dataclasses import dataclass

import torch

from blockstab.search import SearchResult
from blockstab.search.problem import Problem
from blockstab.segments.segmentation import Segmentation


@dataclass(frozen=True)
class NoSearch:
    """Keeps the start."""

    def __call__(self, start: Segmentation, problem: Problem, generator: torch.Generator) -> SearchResult:
        """Rate the start."""
        return SearchResult.of(problem.rate([start]))
