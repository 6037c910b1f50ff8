"""Moves from one segmentation to another: any callables of the shape `Move`, each a class and a line of config."""

from __future__ import annotations

from typing import Protocol

import torch

from blockstab.energy import Rating
from blockstab.search.problem import Problem
from blockstab.segments.segmentation import Segmentation


class Move(Protocol):
    """Proposes neighbours of a segmentation; a class with its settings."""

    def __call__(
        self, rating: Rating, problem: Problem, count: int, generator: torch.Generator, /
    ) -> list[Segmentation]:
        """At most `count` segmentations that differ from the rated one by one move.

        Convention:
            Each is a partition of the same atoms. What is drawn comes from `generator` alone.
        """
