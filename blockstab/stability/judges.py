"""Judges of stability: which of the things that may carry a box do carry it, and which boxes stand."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import NamedTuple, Protocol

import torch
from torch import Tensor

from blockstab.boxes.box import Boxes
from blockstab.stability.balance import Balance, balance
from blockstab.stability.contacts import FRICTION, contacts_of, islands_of, loosened
from blockstab.stability.support import Supports

TOGETHER = (
    1024  # boxes are judged at once, at most, of copies of a scene: the square of their number is what costs
)


class Verdicts(NamedTuple):
    """The supports that count, and which of N boxes stand."""

    supports: Supports
    balance: Balance


class StabilityJudge(Protocol):
    """Says which boxes stand; the plug-in point of `Rules.judge`.

    Boxes of different islands may come at once, and the same boxes several times over, each copy lacking another one
    (see `falls_if_removed`): what is said of one island must not depend on the others.
    """

    def __call__(self, boxes: Boxes, movable: Tensor, candidates: Supports, slack: Tensor) -> Verdicts:
        """Judge.

        Args:
            boxes: N boxes, world frame, +y up.
            movable: (N,) bool; the others are background, and stand.
            candidates: all relations that nearness allows.
            slack: (N,) metres by which each may be off.
        """


@dataclass(frozen=True)
class TrimmedSupports:
    """The paper's rule (section 6): the fewest supports over whose hull the centre of mass lies."""

    def __call__(self, boxes: Boxes, movable: Tensor, candidates: Supports, slack: Tensor) -> Verdicts:
        """The same as `trim` and then `balance`, in machine code; nothing can be differentiated."""
        # Importing numba takes half a second, and most of the package does without it.
        from blockstab.stability.compiled.islands import judged
        from blockstab.stability.compiled.things import Bodies, Relations, arrays

        area = candidates.area
        kept, verdicts = judged(
            Bodies(*arrays(boxes.center, boxes.half_extent, slack, movable)),
            Relations(
                *arrays(
                    candidates.supporter, candidates.supported, candidates.type, area.vertices, area.count
                )
            ),
        )
        return Verdicts(candidates[torch.from_numpy(kept)], Balance(*map(torch.from_numpy, verdicts)))


@dataclass(frozen=True)
class EverySupport:
    """Judge that keeps all candidate supports: the paper's "Neighbor" (section 8.2)."""

    def __call__(self, boxes: Boxes, movable: Tensor, candidates: Supports, slack: Tensor) -> Verdicts:
        """All candidates, and `balance` on them."""
        return Verdicts(candidates, balance(boxes, movable, candidates, slack))


@dataclass(frozen=True)
class StaticEquilibrium:
    """Judge by forces: what no forces of contact can hold where it is does not stand.

    The supports that count, and all figures but the verdict, are those of the paper's rule.

    Args:
        friction: coefficient.
        angle_deg: edges that lean less lie flat.
    """

    friction: float = FRICTION
    angle_deg: float = 20.0

    def __call__(self, boxes: Boxes, movable: Tensor, candidates: Supports, slack: Tensor) -> Verdicts:
        """Ask of each island by itself."""
        from blockstab.stability.equilibrium import moving

        told = TrimmedSupports()(boxes, movable, candidates, slack)
        contacts = contacts_of(boxes, candidates, self.angle_deg)
        if bool((slack > 0).any()):
            contacts = loosened(contacts, slack)
        moves = torch.zeros_like(movable)
        for island, part in islands_of(contacts, movable):
            moves[island] = moving(boxes[island], movable[island], part, self.friction)
        return Verdicts(told.supports, replace(told.balance, stable=~moves))
