"""Removal: the objects that fall without another, by asking the judge again without it."""

from __future__ import annotations

import torch
from torch import Tensor

from blockstab.boxes.box import Boxes
from blockstab.stability.judges import TOGETHER, StabilityJudge, TrimmedSupports
from blockstab.stability.support import Supports

_RULE = TrimmedSupports()


def falls_if_removed(
    boxes: Boxes,
    movable: Tensor,
    candidates: Supports,
    stable: Tensor,
    slack: Tensor,
    judge: StabilityJudge = _RULE,
) -> Tensor:
    """For each box x, the boxes that stand now and would not stand without x.

    Removals are judged together, as one scene with copies of the boxes, each lacking one; what falls is taken
    away too, until nothing more falls.

    Args:
        boxes: N boxes; movable: (N,) bool; candidates: all relations that nearness allows.
        stable: (N,) bool, the verdict with everything in place; slack: (N,) metres, as in `balance`.
        judge: that gave this verdict, and is asked again.

    Returns:
        (N, N) bool; row x, column b: b falls if x is removed. Rows of background are false.
    """
    n = len(boxes)
    gone = torch.eye(n, dtype=torch.bool)
    fallen = torch.zeros_like(gone)
    # Rows still open: at first those whose box holds something up or weighs on something.
    relevant = torch.zeros(n, dtype=torch.bool)
    between = candidates.supporter >= 0
    relevant[candidates.supporter[between]] = True
    relevant[candidates.supported[between]] = True
    rows = (relevant & movable).nonzero()[:, 0]
    while len(rows):
        stands = standing_without(boxes, movable, candidates, (gone | fallen)[rows], slack, judge)
        further = ~stands & stable & movable & ~gone[rows] & ~fallen[rows]
        fallen[rows] |= further
        rows = rows[further.any(dim=1)]
    return fallen


def standing_without(
    boxes: Boxes, movable: Tensor, candidates: Supports, absent: Tensor, slack: Tensor, judge: StabilityJudge
) -> Tensor:
    """(K, N) bool: whether box b (column) stands in the copy (row) that lacks the boxes marked absent (K, N)."""
    n = len(boxes)
    together = max(1, TOGETHER // max(n, 1))
    parts = [
        _together(boxes, movable, candidates, some, slack, judge) for some in torch.split(absent, together)
    ]
    return torch.cat(parts)


def _together(
    boxes: Boxes, movable: Tensor, candidates: Supports, absent: Tensor, slack: Tensor, judge: StabilityJudge
) -> Tensor:
    k, n = absent.shape
    edge = torch.arange(len(candidates)).repeat(k)
    copy = torch.arange(k).repeat_interleave(len(candidates))
    below, above = candidates.supporter[edge], candidates.supported[edge]
    present = ~absent[copy, above] & ~(absent[copy, below.clamp(min=0)] & (below >= 0))
    edge, copy, below, above = edge[present], copy[present], below[present], above[present]
    copies = Supports(
        torch.where(below >= 0, below + copy * n, below),
        above + copy * n,
        candidates.type[edge],
        candidates.area[edge],
    )
    many = boxes[torch.arange(n).repeat(k)]
    return judge(many, movable.repeat(k), copies, slack.repeat(k)).balance.stable.view(k, n)
