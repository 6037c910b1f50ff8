"""Simulated scenes as a set: made when first asked for, and used again."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

from blockstab.datasets.sets import FolderScenes
from blockstab.datasets.truth import Truth
from blockstab.rgbd.frame import Frame
from blockstab.simulation.simulated import Recipe
from blockstab.simulation.writing import write_simulated


@dataclass(frozen=True)
class SimulatedScenes:
    """Scenes of a preset, made once in a folder of the cache.

    Args:
        preset, seed, sensor, variety: as in `Recipe`.
        count: how many scenes.
        cache: where sets are kept, each in a folder of its own.
        jobs: scenes made side by side; the scenes do not depend on it.
    """

    preset: str = "blocks"
    count: int = 40
    seed: int = 1000
    sensor: str = "kinect"
    variety: float = 1.0
    cache: str | Path = ".cache/simulated"
    jobs: int = 2

    @property
    def name(self) -> str:
        """Name of the set, from its preset, count, seed, sensor and variety."""
        return f"{self.preset}_{self.count}_seed{self.seed}_{self.sensor}_variety{self.variety:g}"

    @cached_property
    def made(self) -> FolderScenes:
        """The scenes on disk; those that are missing are made."""
        root = Path(self.cache) / self.name
        write_simulated(root, self.recipe(), self.count, self.jobs)
        return FolderScenes(root)

    def recipe(self) -> Recipe:
        """The recipe of its scenes."""
        return Recipe(self.preset, self.seed, self.sensor, self.variety)

    def scenes(self) -> list[str]:
        """The names of the scenes, in order."""
        return self.made.scenes()[: self.count]

    def read(self, scene: str) -> tuple[Frame, Truth]:
        """One scene."""
        return self.made.read(scene)

    def stamp(self, scene: str) -> str:
        """A hash of the scene's files."""
        return self.made.stamp(scene)

    def official(self) -> Mapping[str, Sequence[str]]:
        """None: another seed makes another set."""
        return {}
