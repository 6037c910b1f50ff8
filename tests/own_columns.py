"""A column of features that is not ours."""

from __future__ import annotations

from dataclasses import dataclass

from torch import Tensor

from blockstab.observation import Observation
from blockstab.scene.types import Scene
from blockstab.segments.atoms import Atoms


@dataclass(frozen=True)
class Height:
    """How high the middle of the box is, above a level."""

    level_m: float = 0.0
    columns = ("height",)

    def __call__(self, observation: Observation, atoms: Atoms, scene: Scene, /) -> Tensor:
        """(N, 1) metres."""
        return scene.boxes.center[:, 1:2] - self.level_m
