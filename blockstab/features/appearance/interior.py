"""Pixels near the borders of regions."""

from __future__ import annotations

import numpy as np
import torch
from torch import Tensor

BORDER_PX = 4
"""Pixels no farther than this from another region are the border of a region, all others its interior: what a disc
of 3 pixels about every outermost pixel covers."""


def near_others(label: Tensor) -> Tensor:
    """(H, W) bool: pixels that have one with another label no farther than `BORDER_PX` away."""
    near = torch.zeros_like(label, dtype=torch.bool)
    for here, there in _windows(label.shape[0], label.shape[1]):
        differ = label[here] != label[there]
        near[here] |= differ
        near[there] |= differ
    return near


def others_near(label: Tensor) -> tuple[Tensor, Tensor]:
    """For each pixel the other labels that it has no farther than `BORDER_PX` away.

    Returns:
        (N,) int64 pixels, sorted, and (N,) int64 labels, sorted for each pixel, each pair once.
    """
    flat, most = label.flatten(), int(label.max()) + 1
    number = torch.arange(label.numel()).view_as(label)
    found = []
    for here, there in _windows(label.shape[0], label.shape[1]):
        differ = (label[here] != label[there]).flatten().nonzero()[:, 0]
        one, other = number[here].flatten()[differ], number[there].flatten()[differ]
        found += [one * most + flat[other], other * most + flat[one]]
    pairs = torch.from_numpy(np.sort(torch.cat(found).numpy()))
    pairs = torch.unique_consecutive(pairs)
    return pairs // most, pairs % most


def _windows(height: int, width: int) -> list[tuple[tuple[slice, slice], tuple[slice, slice]]]:
    """Pairs of windows of an image whose pixels are no farther than `BORDER_PX` apart, one of each opposite two."""
    reach = range(-BORDER_PX, BORDER_PX + 1)
    steps = [(r, c) for r in reach for c in reach if (r, c) > (0, 0) and r * r + c * c <= BORDER_PX**2]
    return [
        (
            (slice(0, height - r), slice(max(-c, 0), width - max(c, 0))),
            (slice(r, height), slice(max(c, 0), width - max(-c, 0))),
        )
        for r, c in steps
        if r < height and abs(c) < width
    ]
