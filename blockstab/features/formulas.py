"""Tables of formulas: the name of a column and how it is computed stand in one line."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TypeVar

import torch
from torch import Tensor

Measured = TypeVar("Measured")


def columns_of(formulas: Mapping[str, Callable[[Measured], Tensor]], measured: Measured) -> Tensor:
    """The value of every formula, (S, C) float64, in their order; each gives (S,)."""
    return torch.stack([formula(measured).to(torch.float64) for formula in formulas.values()], dim=1)
