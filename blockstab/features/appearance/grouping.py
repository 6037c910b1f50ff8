"""Sums, extremes and samples of values by group."""

from __future__ import annotations

from typing import Literal

import torch
from torch import Tensor


def or_all(chosen: Tensor, size: Tensor, group: Tensor, count: int, least: int) -> Tensor:
    """The choice, (N,) bool, and all members of the groups of which what it has in size, (N,), is below `least`."""
    return chosen | (summed(size * chosen, group, count) < least)[group]


def summed(values: Tensor, group: Tensor, count: int) -> Tensor:
    """(count, ...) sums by group of (N, ...) values; 0 where there is none."""
    return values.new_zeros(count, *values.shape[1:]).index_add(0, group, values)


def extreme(values: Tensor, group: Tensor, count: int, which: Literal["amin", "amax"]) -> Tensor:
    """(count, C) the least or greatest by group of (N, C) values; 0 where there is none."""
    index = group[:, None].expand_as(values)
    return values.new_zeros(count, values.shape[1]).scatter_reduce(
        0, index, values, which, include_self=False
    )


def tables(number: Tensor, group: Tensor, count: int, most: int) -> Tensor:
    """(count, most) float64, how often a group has each number from 0 to `most` - 1."""
    return torch.bincount(group * most + number, minlength=count * most).view(count, most).double()


def first_of_each(group: Tensor, count: int, most: int) -> tuple[Tensor, Tensor]:
    """Places of the first entries of every group, in a sorted list (N,) that names each at least once.

    Returns:
        (count, most) int64, which begin again where a group has fewer; and (count,) how many differ.
    """
    number = torch.bincount(group, minlength=count)
    start = number.cumsum(0) - number
    return start[:, None] + torch.arange(most) % number[:, None], number.clamp(max=most)
