"""What falls if a thing is taken away, by asking the stability rule again without it."""

from __future__ import annotations

import torch
from torch import Tensor

from blockstab.boxes.box import Boxes
from blockstab.stability.balance import balance
from blockstab.stability.support import Supports
from blockstab.stability.trimming import trim


def falls_if_removed(
    boxes: Boxes, movable: Tensor, candidates: Supports, stable: Tensor, slack: Tensor
) -> Tensor:
    """For each box x, the boxes that stand now and would not stand without x.

    All removals are judged together, as one scene with N copies of the boxes, each lacking one; what falls is
    taken away too, until nothing more falls.

    Args:
        boxes: N boxes; movable: (N,) bool; candidates: all relations that nearness allows.
        stable: (N,) bool, the verdict with everything in place; slack: (N,) metres, as in `balance`.

    Returns:
        (N, N) bool; row x, column b: b falls if x is removed. Rows of background are false.
    """
    n = len(boxes)
    gone = torch.eye(n, dtype=torch.bool) & movable[:, None]
    fallen = torch.zeros_like(gone)
    for _ in range(n):
        stands = _verdicts(boxes, movable, candidates, gone | fallen, slack)
        further = ~stands & stable & movable & ~gone & movable[:, None]
        if not bool((further & ~fallen).any()):
            break
        fallen |= further
    return fallen


def _verdicts(boxes: Boxes, movable: Tensor, candidates: Supports, absent: Tensor, slack: Tensor) -> Tensor:
    """(N, N) bool: whether box b (column) stands in the copy (row) that lacks the boxes marked absent."""
    n = len(boxes)
    edge = torch.arange(len(candidates))
    copy = torch.arange(n)[:, None].expand(n, len(edge)).flatten()
    edge = edge.repeat(n)
    below, above = candidates.supporter[edge], candidates.supported[edge]
    present = ~absent[copy, above] & ~(absent[copy, below.clamp(min=0)] & (below >= 0))
    edge, copy, below, above = edge[present], copy[present], below[present], above[present]
    copies = Supports(
        torch.where(below >= 0, below + copy * n, below),
        above + copy * n,
        candidates.type[edge],
        candidates.area[edge],
    )
    many = boxes[torch.arange(n).repeat(n)]
    kept = trim(many, copies, slack.repeat(n))
    return balance(many, movable.repeat(n), kept, slack.repeat(n)).stable.view(n, n)
