"""Scenes that do not stand: pictures of things that would fall, as nothing real can show them."""

from __future__ import annotations

from dataclasses import dataclass

import torch

from blockstab.simulation.cached import SimulatedScenes
from blockstab.simulation.layouts.draws import choice
from blockstab.simulation.layouts.presets import preset
from blockstab.simulation.layouts.unsettled import placed_unsettled
from blockstab.simulation.physics.settling import falls, moves
from blockstab.simulation.simulated import Arranged, Recipe, resting_pile

_ATTEMPTS = 50


@dataclass(frozen=True)
class WithoutSupport(Recipe):
    """Recipe of scenes at rest, out of which something was taken that others hang on; they are where they were."""

    def scene(self, index: int) -> str:
        """Name of scene number `index`."""
        return f"{super().scene(index)}_without"

    def arranged(self, generator: torch.Generator) -> Arranged:
        """A pile of which something would move.

        Raises:
            RuntimeError: in many piles nothing hangs on anything.
        """
        for _ in range(_ATTEMPTS):
            pile, _ = resting_pile(preset(self.preset), generator)
            fallen = falls(pile)
            carriers = fallen.any(dim=1).nonzero()[:, 0].tolist()
            if carriers:
                taken = choice(generator, carriers)
                left = [i for i in range(len(pile)) if i != taken]
                return Arranged(pile[left], None, fallen[taken, left])
        raise RuntimeError(f"In none of {_ATTEMPTS} piles of {self.preset} did one thing hang on another.")


@dataclass(frozen=True)
class LetGo(Recipe):
    """Recipe of pictures of boxes put down where some of them do not stay (`placed_unsettled`)."""

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.preset != "blocks":
            raise ValueError(f"Only blocks can be put down so that they do not stay, not {self.preset}.")

    def scene(self, index: int) -> str:
        """Name of scene number `index`."""
        return f"{super().scene(index)}_let_go"

    def arranged(self, generator: torch.Generator) -> Arranged:
        """Boxes of which something would move.

        Raises:
            RuntimeError: many arrangements stand.
        """
        for _ in range(_ATTEMPTS):
            pile = placed_unsettled(generator)
            moved = moves(pile)
            if bool(moved.any()):
                return Arranged(pile, None, moved)
        raise RuntimeError(f"All of {_ATTEMPTS} arrangements stand.")


SPOILT: dict[str, type[Recipe]] = {"support": WithoutSupport, "let_go": LetGo}
"""The ways in which a scene is spoilt, by name."""


def spoilt(way: str) -> type[Recipe]:
    """The recipe of that name.

    Raises:
        ValueError: if there is none.
    """
    if way not in SPOILT:
        raise ValueError(
            f"There is no way to spoil a scene named {way!r:.80}; choose from: {', '.join(SPOILT)}."
        )
    return SPOILT[way]


@dataclass(frozen=True)
class SpoiltScenes(SimulatedScenes):
    """Spoilt scenes of a preset, made once in a folder of the cache.

    Args:
        way: a key of `SPOILT`.
    """

    way: str = "support"

    @property
    def name(self) -> str:
        """Name of the set."""
        return f"{super().name}_{self.way}"

    def recipe(self) -> Recipe:
        """The recipe of its scenes."""
        return spoilt(self.way)(self.preset, self.seed, self.sensor, self.variety)
