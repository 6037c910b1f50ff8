"""Removal of things from a scene: what falls without each, why, and an order in which nothing does."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from blockstab.scene.inference import Rules
from blockstab.scene.types import Scene
from blockstab.stability.removal import falls_if_removed
from blockstab.stability.taking_apart import Reason, reasons, removal_order


@dataclass(frozen=True)
class Removal:
    """Removal of each thing of a scene.

    Args:
        falls: by segment index, the indices of the segments that fall if it is removed.
        reasons: by segment index and that of one that falls without it, why.
        order: of the indices of all things, in which they can be taken away one at a time while nothing falls;
            None where there is none.
    """

    falls: Mapping[int, tuple[int, ...]]
    reasons: Mapping[tuple[int, int], Reason]
    order: tuple[int, ...] | None


def removal_of(scene: Scene, rules: Rules) -> Removal:
    """Ask the judge of a scene what falls without each of its things."""
    slack, movable = rules.support.noise(scene.boxes), ~scene.background
    asked = scene.boxes, movable, scene.candidates, scene.balance.stable, slack, rules.judge
    table = falls_if_removed(*asked)
    falls = {i: tuple(row.nonzero()[:, 0].tolist()) for i, row in enumerate(table)}
    return Removal(falls, reasons(scene.supports, table), removal_order(*asked))
