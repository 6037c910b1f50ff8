"""Training objective: that of support vector regression, for any head (paper, section 7.1)."""

from __future__ import annotations

from collections.abc import Iterable

import torch
from torch import Tensor

EPSILON = 0.1  # errors below this cost nothing


def balanced_weights(target: Tensor, good: float = 0.0) -> Tensor:
    """A weight for each row, (N,), so that good rows weigh as much as bad ones and the mean is one.

    Args:
        target: (N,) badness, from 0 to 1.
        good: badness up to which a row is good.

    Raises:
        ValueError: if a target lies outside, or good or bad rows are missing.
    """
    bad = target > good
    if not bool(((target >= 0) & (target <= 1)).all()) or bool(bad.all()) or not bool(bad.any()):
        values = sorted(set(target.tolist()))
        raise ValueError(
            f"Targets must lie between 0 (good) and 1 (bad), and both kinds occur, but they hold {values[:5]}; "
            "train on segmentations that are right in parts and wrong in others."
        )
    share = torch.where(bad, bad.double().mean(), (~bad).double().mean())
    return 0.5 / share


def squared_epsilon_insensitive(potentials: Tensor, target: Tensor, weight: Tensor) -> Tensor:
    """Weighted mean of `max(0, |target - potential| - EPSILON)^2`.

    Args:
        potentials, target, weight: (N,); the weights need not sum to one.

    Returns:
        A scalar. It is differentiable everywhere, and zero inside the tube of half width `EPSILON`.
    """
    excess = ((target - potentials).abs() - EPSILON).clamp(min=0)
    return (weight * excess.square()).sum() / weight.sum()


def svr_objective(
    potentials: Tensor, target: Tensor, weight: Tensor, parameters: Iterable[Tensor], c: float
) -> Tensor:
    """The loss and the penalty on large parameters.

    Args:
        potentials, target, weight: (N,).
        parameters: all those of the head, the bias among them.
        c: inverse strength of the penalty, in the unit of LIBLINEAR's C (Fan et al. 2008).

    Convention:
        This is LIBLINEAR's `0.5 * |w|^2 + C * sum(weight * excess^2)`, where the bias is one of w, divided by
        `C * sum(weight)`: the optimum is the same, and the size does not depend on the number of rows.
    """
    squares = torch.stack([p.square().sum() for p in parameters]).sum()
    return squared_epsilon_insensitive(potentials, target, weight) + squares / (2 * c * weight.sum())
