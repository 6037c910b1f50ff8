"""Arrangements of blocks on the ground, as a file would give them."""

from __future__ import annotations

import torch

from blockstab.stability.arrangement import Arrangement
from blockstab.stability.support import SupportRules
from blockstab.testing.worlds import Block, build


def arranged(*blocks: Block, lifted: float = 0.0) -> Arrangement:
    """The blocks, in a frame whose ground lies at y = `lifted`."""
    boxes, movable = build(*blocks)
    boxes.center[:, 1] += lifted
    rules = SupportRules(touch_m=0.005, touch_per_square_m=0.0)
    names = tuple(f"block_{k}" for k in range(len(boxes)))
    return Arrangement(names, boxes, movable, lifted, rules, torch.zeros(len(boxes), dtype=torch.float64))
