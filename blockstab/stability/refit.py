"""Refit axes of boxes that follow the surface they stand on (paper, section 6, "Box fitting"; Fig. 10)."""

from __future__ import annotations

import torch
from torch import Tensor

from blockstab.boxes.box import Boxes
from blockstab.stability.support import GROUND, Supports, SupportType, top_normal

UP = torch.tensor([0.0, 1.0, 0.0], dtype=torch.float64)


def refit_axes(boxes: Boxes, supports: Supports, eligible: Tensor) -> Tensor:
    """The axis that each box is to be fitted to: the normal of the surface it stands on.

    A box follows its supporter if it stands on exactly one, by surface, and on nothing else. Supporters come
    first, so that a whole tower follows the ground it stands on.

    Args:
        boxes: N boxes; supports: the relations that stability needs; eligible: (N,) bool, stable and movable.

    Returns:
        (N, 3) unit vectors; NaN for boxes that stay as they are.
    """
    n = len(boxes)
    amount = torch.bincount(supports.supported, minlength=n)
    single = (amount[supports.supported] == 1) & (supports.type == SupportType.SURFACE)
    single &= eligible[supports.supported]
    below = torch.full((n,), n + 1)
    below[supports.supported[single]] = supports.supporter[single]
    follows = below <= n
    axes = torch.full((n, 3), float("nan"), dtype=boxes.center.dtype)
    axes[below == GROUND] = UP
    known = (below == GROUND) | ~follows
    own = top_normal(boxes)
    while not bool(known.all()):
        ready = ~known & known[below.clamp(min=0, max=n - 1)]
        under = below[ready]
        axes[ready] = torch.where(axes[under].isnan(), own[under], axes[under])
        known = known | ready
    return axes
