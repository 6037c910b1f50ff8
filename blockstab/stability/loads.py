"""Loads: the boxes that each box carries (paper, section 6, from top to bottom)."""

from __future__ import annotations

import torch
from torch import Tensor


def levels(upper: Tensor, lower: Tensor, n: int) -> Tensor:
    """(N,) how many layers of boxes lie on each box, 0 for those on top.

    Args:
        upper, lower: (E,) int64: box `upper[e]` rests on box `lower[e]`; no box rests on itself through others.
    """
    level = torch.zeros(n, dtype=torch.long)
    while True:
        raised = level.scatter_reduce(0, lower, level[upper] + 1, "amax")
        if torch.equal(raised, level):
            return level
        level = raised


def loads(upper: Tensor, lower: Tensor, n: int) -> Tensor:
    """(N, N) bool: row b holds b and every box that rests, through however many others, on b."""
    load, level = torch.eye(n, dtype=torch.bool), levels(upper, lower, n)
    for height in range(int(level.max()) if n else 0):
        now = level[upper] == height
        pass_down(load, upper[now], lower[now])
    return load


def pass_down(load: Tensor, upper: Tensor, lower: Tensor) -> None:
    """Add the rows of `load` (N, N) of the boxes `upper` (E,) to those of the boxes `lower` (E,), in place."""
    below, place = torch.unique(lower, return_inverse=True)
    added = torch.zeros(len(below), load.shape[1], dtype=torch.int32)
    added.index_add_(0, place, load[upper].to(torch.int32))
    load[below] |= added > 0
