"""Scores of boxes and of supports (paper, sections 8.1 and 8.2)."""

from __future__ import annotations

from itertools import permutations

import torch
from torch import Tensor


def axis_error_deg(rotation: Tensor, truth: Tensor) -> Tensor:
    """Angular error of the axes of boxes against the true ones.

    Axes have no sign and no order: of all one-to-one matches, the one of least summed angle counts.

    Args:
        rotation, truth: (N, 3, 3), columns are axes, in one frame.

    Returns:
        (N,) the mean of the three angles, degrees.
    """
    cosine = (rotation.transpose(1, 2) @ truth).abs().clamp(max=1.0)
    angle = torch.rad2deg(torch.acos(cosine))
    each = [angle[:, list(order), range(3)].mean(dim=1) for order in permutations(range(3))]
    return torch.stack(each).amin(dim=0)


def support_accuracy(truth: dict[int, set[int]], predicted: dict[int, set[int]]) -> float:
    """Share of objects whose supporters are exactly the true ones (the paper's "all its supporting objects").

    Args:
        truth: the supporters of each scored object; predicted: those found, by the same ids.

    Returns:
        between 0 and 1; NaN without objects.
    """
    if not truth:
        return float("nan")
    return sum(predicted.get(identity, set()) == below for identity, below in truth.items()) / len(truth)
