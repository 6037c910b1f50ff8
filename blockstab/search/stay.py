"""No search: the segmentation is understood as it is."""

from __future__ import annotations

from dataclasses import dataclass

import torch

from blockstab.search import Found
from blockstab.search.problem import Problem
from blockstab.segments.segmentation import Segmentation


@dataclass(frozen=True)
class Stay:
    """Keeps the start."""

    def __call__(self, start: Segmentation, problem: Problem, generator: torch.Generator) -> Found:
        """Rate the start."""
        return Found.of(problem.rate([start]))
