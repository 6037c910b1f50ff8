"""Taking a scene apart: an order in which nothing falls, and why what falls does."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from enum import StrEnum

import torch
from torch import Tensor

from blockstab.boxes.box import Boxes
from blockstab.stability.contacts import linked
from blockstab.stability.judges import StabilityJudge, TrimmedSupports
from blockstab.stability.removal import standing_without
from blockstab.stability.support import Supports

_RULE = TrimmedSupports()
_MOST_STATES = 5000  # of one island that are looked at; so many come up only where some of it can never go

Free = Callable[[frozenset[int]], list[int]]  # from what is gone to what may go next, the best first


class Reason(StrEnum):
    """Reason for which a box falls when another is taken away."""

    SUPPORT = "support"  # it stood on it, or leaned on it, or on something that did
    COUNTERWEIGHT = "counterweight"  # it was held down by its weight
    NEIGHBOUR = "neighbour"  # it was held by something that falls too


def removal_order(
    boxes: Boxes,
    movable: Tensor,
    candidates: Supports,
    stable: Tensor,
    slack: Tensor,
    judge: StabilityJudge = _RULE,
) -> tuple[int, ...] | None:
    """An order in which all objects can be taken away one at a time while nothing falls; None where there is none.

    Of what may go next the highest goes first; where that leads nowhere, the next. What falls as it is does not
    count. Islands are taken apart one after the other. Of an island so entangled that 5,000 states do not settle it,
    it is said that there is none.

    Args:
        boxes: N boxes; movable: (N,) bool; candidates: all relations that nearness allows.
        stable: (N,) bool, the verdict with everything in place; slack: (N,) metres, as in `balance`.
        judge: that gave this verdict, and is asked again.
    """
    height = boxes.center[:, 1].tolist()

    def free(gone: frozenset[int], island: Sequence[int]) -> list[int]:
        left = [i for i in island if i not in gone]
        absent = torch.zeros(len(left), len(boxes), dtype=torch.bool)
        absent[:, list(gone)] = True
        absent[torch.arange(len(left)), left] = True
        stands = standing_without(boxes, movable, candidates, absent, slack, judge)
        safe = (stands | absent | ~stable | ~movable).all(dim=1).tolist()
        return [i for i, may_go in zip(left, safe, strict=True) if may_go]

    order: list[int] = []
    number = linked(candidates.supporter, candidates.supported, movable)
    for island in dict.fromkeys(number[movable].tolist()):
        objects = ((number == island) & movable).nonzero()[:, 0].tolist()
        highest_first = sorted(objects, key=lambda i: (-height[i], i))
        found = _emptied(highest_first, lambda gone: free(gone, highest_first))  # noqa: B023  (called at once)
        if found is None:
            return None
        order += found
    return tuple(order)


def reasons(supports: Supports, falls: Tensor) -> dict[tuple[int, int], Reason]:
    """For each pair (taken, fallen) of a table of `falls_if_removed`, why.

    Args:
        supports: the relations that count with everything in place; falls: (N, N) bool.
    """
    held_by = _held(supports, len(falls))
    found = {}
    for taken, fallen in falls.nonzero().tolist():
        if bool(held_by[taken, fallen]):
            found[taken, fallen] = Reason.SUPPORT
        else:
            found[taken, fallen] = Reason.COUNTERWEIGHT if bool(held_by[fallen, taken]) else Reason.NEIGHBOUR
    return found


def _held(supports: Supports, n: int) -> Tensor:
    """(N, N) bool: row b has all boxes that b holds up, through however many others."""
    between = supports.supporter >= 0
    held = torch.zeros(n, n, dtype=torch.bool)
    held[supports.supporter[between], supports.supported[between]] = True
    while True:
        further = held | (held.double() @ held.double() > 0)
        if torch.equal(further, held):
            return held
        held = further


def _emptied(island: Sequence[int], free: Free) -> list[int] | None:
    """An order in which an island can be emptied."""
    dead_ends = set[frozenset[int]]()
    order: list[int] = []
    choices = [iter(free(frozenset()))]
    while len(order) < len(island):
        gone = frozenset(order)
        following = next((i for i in choices[-1] if gone | {i} not in dead_ends), None)
        if following is not None:
            order.append(following)
            choices.append(iter(free(gone | {following})))
            continue
        dead_ends.add(gone)
        if not order or len(dead_ends) > _MOST_STATES:
            return None
        order.pop()
        choices.pop()
    return order
