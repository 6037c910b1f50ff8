"""Random numbers that belong to a segment: same pixels, same numbers, in any order and in any process."""

from __future__ import annotations

import torch
from torch import Tensor

_GOLDEN = -7046029254386353131  # 0x9E3779B97F4A7C15 as a signed number
_MIX_1 = -4658895280553007687  # 0xBF58476D1CE4E5B9
_MIX_2 = -7723592293110705685  # 0x94D049BB133111EB


def scramble(numbers: Tensor) -> Tensor:
    """Map int64 numbers to int64 numbers that look random, one to one (SplitMix64: Steele, Lea, Flood 2014)."""
    x = numbers + _GOLDEN
    x = (x ^ _shift_right(x, 30)) * _MIX_1
    x = (x ^ _shift_right(x, 27)) * _MIX_2
    return x ^ _shift_right(x, 31)


def uniform(seed: Tensor, count: int, stream: int) -> Tensor:
    """Uniform numbers in [0, 1) for each seed.

    Args:
        seed: (N,) int64, one per segment.
        count: how many numbers each gets.
        stream: which of a segment's independent sequences to draw.

    Returns:
        (N, count) float64.
    """
    counter = torch.arange(count, dtype=torch.int64, device=seed.device) + (stream << 32)
    bits = scramble(scramble(seed)[:, None] + counter)
    return _shift_right(bits, 11).to(torch.float64) / float(1 << 53)


def _shift_right(x: Tensor, places: int) -> Tensor:
    """Logical shift: torch shifts int64 with its sign."""
    return (x >> places) & ((1 << (64 - places)) - 1)
