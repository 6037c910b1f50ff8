"""Runs of consecutive numbers, laid out one after the other."""

from __future__ import annotations

import torch
from torch import Tensor


def spans(start: Tensor, count: Tensor) -> tuple[Tensor, Tensor]:
    """The numbers `start`, `start + 1`, ..., `count` of them, for each of N spans.

    Returns:
        (M,) int64 numbers, span after span, and (M,) int64, which span each is of.
    """
    span = torch.arange(len(count)).repeat_interleave(count)
    return torch.arange(len(span)) + (start - (count.cumsum(0) - count))[span], span
