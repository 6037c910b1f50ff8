"""Judges of stability: which of the things that may carry a box do carry it, and which boxes stand."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple, Protocol

import torch
from torch import Tensor

from blockstab.boxes.box import Boxes
from blockstab.stability.balance import Balance, balance
from blockstab.stability.support import Supports


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
