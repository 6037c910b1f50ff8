"""Label images for the tests of scores."""

from __future__ import annotations

from collections.abc import Sequence

import torch
from torch import Tensor


def two_squares() -> Tensor:
    """Squares 3 and 8 of four by four pixels, side by side, and a rim without label."""
    label = torch.zeros(6, 10, dtype=torch.int64)
    label[1:5, 1:5], label[1:5, 5:9] = 3, 8
    return label


def scattered(ids: Sequence[int], generator: torch.Generator, size: tuple[int, int] = (20, 30)) -> Tensor:
    """(H, W) int64: every pixel has one of the ids, drawn by itself."""
    return torch.tensor(ids)[torch.randint(len(ids), size, generator=generator)]


def patches(ids: Sequence[int], generator: torch.Generator, size: tuple[int, int] = (24, 32)) -> Tensor:
    """(H, W) int64: rectangles, the later ones over the earlier, on pixels without label."""
    label = torch.zeros(size, dtype=torch.int64)
    for identity in ids:
        top, left = (int(torch.randint(side - 4, (1,), generator=generator)) for side in size)
        height, width = torch.randint(3, 14, (2,), generator=generator).tolist()
        label[top : top + height, left : left + width] = identity
    return label
