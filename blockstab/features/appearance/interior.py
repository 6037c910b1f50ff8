"""Pixels near the borders of regions."""

from __future__ import annotations

import numpy as np
import torch
from torch import Tensor

BORDER_PX = 4
"""Pixels no farther than this from another region are the border of a region, all others its interior: what a disc
of 3 pixels about every outermost pixel covers."""


_REACH = range(-BORDER_PX, BORDER_PX + 1)
_STEPS = np.array([(r, c) for r in _REACH for c in _REACH if 0 < r * r + c * c <= BORDER_PX**2])


def near_others(label: Tensor) -> Tensor:
    """(H, W) bool: pixels that have one with another label no farther than `BORDER_PX` away."""
    near = torch.zeros(label.numel(), dtype=torch.bool)
    near[others_near(label)[0]] = True
    return near.view_as(label)


def others_near(label: Tensor) -> tuple[Tensor, Tensor]:
    """For each pixel the other labels that it has no farther than `BORDER_PX` away.

    Returns:
        (N,) int64 pixels, sorted, and (N,) int64 labels, sorted for each pixel, each pair once.
    """
    # Importing numba takes half a second, and most of the package does without it.
    from blockstab.features.compiled.nearness import labels_near

    pixel, other = labels_near(label.contiguous().numpy(), _STEPS)
    return torch.from_numpy(pixel), torch.from_numpy(other)
