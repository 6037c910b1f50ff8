"""Turn an object into background, or background into an object."""

from __future__ import annotations

from dataclasses import dataclass

import torch

from blockstab.energy import Rating
from blockstab.search.moves.drawing import draw
from blockstab.search.problem import Problem
from blockstab.segments.segmentation import Segmentation


@dataclass(frozen=True)
class Turn:
    """A segment changes sides, drawn by what is gained by what the two potentials say."""

    def __call__(
        self, rating: Rating, problem: Problem, count: int, generator: torch.Generator
    ) -> list[Segmentation]:
        """At most `count` segments turned."""
        scene = rating.scene
        now = scene.segmentation
        lost, phi = problem.describe.lost(scene), rating.unary.detach().clamp(0.0, 1.0)
        gain = scene.pixel_count * torch.where(scene.background, lost - phi, phi - lost)
        turned = dict.fromkeys(draw(gain, torch.ones(len(scene), dtype=torch.bool), count, generator))
        return [now.telling({now.segments[k]: not bool(scene.background[k])}) for k in turned]
