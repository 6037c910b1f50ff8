"""An energy that tells what it is shown."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from blockstab.energy import Energy, Rating
from blockstab.features.description import Described


@dataclass(frozen=True)
class Recorder:
    """Rates as another energy does, and passes on every scene that it is asked about, with its rating.

    Args:
        energy: the other.
        keep: called for each scene, in the order in which a search asks about them.
    """

    energy: Energy
    keep: Callable[[Described, Rating], object]

    def __call__(self, scenes: Sequence[Described]) -> list[Rating]:
        """Rate scenes."""
        ratings = self.energy(scenes)
        for scene, rating in zip(scenes, ratings, strict=True):
            self.keep(scene, rating)
        return ratings
