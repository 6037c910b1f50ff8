"""Numbers, choices and turns drawn at random from a generator."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypeVar

import torch
from torch import Tensor

from blockstab.boxes.box import rotation_of

T = TypeVar("T")


def uniform(generator: torch.Generator, low: float, high: float) -> float:
    """A number between `low` and `high`."""
    return low + (high - low) * float(torch.rand((), generator=generator, dtype=torch.float64))


def twist(generator: torch.Generator, most: float) -> float:
    """A number from `-most` to `most`."""
    return uniform(generator, -most, most)


def whole(generator: torch.Generator, low: int, high: int) -> int:
    """A whole number from `low` to `high`, both included."""
    return int(torch.randint(low, high + 1, (), generator=generator))


def chance(generator: torch.Generator, probability: float) -> bool:
    """True with this probability."""
    return uniform(generator, 0.0, 1.0) < probability


def choice(generator: torch.Generator, items: Sequence[T]) -> T:
    """One of the items, all equally likely."""
    return items[whole(generator, 0, len(items) - 1)]


def any_turn(generator: torch.Generator) -> Tensor:
    """A rotation (3, 3), all equally likely: that of a unit quaternion drawn evenly."""
    return rotation_of(torch.randn(4, generator=generator, dtype=torch.float64))
