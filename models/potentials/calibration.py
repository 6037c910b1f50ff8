"""From potentials to probabilities: Platt scaling (Platt 1999)."""

from __future__ import annotations

import torch
from torch import Tensor

_STEPS = 100
_FLAT = 1e-10  # per row: a gradient this small ends the search
_RIDGE = 1e-12  # keeps the Hessian invertible when all potentials are equal
_SHORTEST = 1e-10  # of a Newton step: no shorter one is tried


def platt(potentials: Tensor, target: Tensor, weights: Tensor | None = None) -> tuple[float, float]:
    """The a and b for which `sigmoid(a * potential + b)` fits the targets best.

    The targets are smoothed as Platt proposed, so that separable potentials give a finite answer. The
    search is Newton's with backtracking, in the form that neither overflows nor cancels (Lin, Lin and
    Weng 2007).

    Args:
        potentials: (N,) best taken from fits that did not see the row; N >= 1.
        target: (N,) badness, 0 or 1.
        weights: (N,) how often each row counts; once where not given.

    Returns:
        (a, b); a is positive where higher potentials go with higher badness.

    Raises:
        ValueError: if the shapes differ, or there is no row.
    """
    if potentials.ndim != 1 or potentials.shape != target.shape or len(potentials) == 0:
        raise ValueError(
            "Platt scaling needs one target for each of at least one potential, but got shapes "
            f"{tuple(potentials.shape)} and {tuple(target.shape)}."
        )
    f, y = potentials.detach().double(), target.double()
    weight = torch.ones_like(f) if weights is None else weights.double()
    bad, good = (weight * y).sum(), (weight * (1 - y)).sum()
    goal = torch.where(y > 0.5, (bad + 1) / (bad + 2), 1 / (good + 2))
    rows = torch.stack([f, torch.ones_like(f)], dim=1)
    ab = torch.stack([f.new_zeros(()), torch.log((bad + 1) / (good + 1))])
    loss = _loss(rows, goal, weight, ab)
    for _ in range(_STEPS):
        p = torch.sigmoid(rows @ ab)
        gradient = rows.T @ (weight * (p - goal))
        if float(gradient.abs().max()) < _FLAT * float(weight.sum()):
            break
        hessian = (rows * (weight * p * (1 - p))[:, None]).T @ rows
        step = -torch.linalg.solve(hessian + _RIDGE * torch.eye(2).to(hessian), gradient)
        slope, length = gradient @ step, 1.0
        while (
            length > _SHORTEST
            and _loss(rows, goal, weight, ab + length * step) > loss + 1e-4 * length * slope
        ):
            length /= 2
        if length <= _SHORTEST:
            break
        ab = ab + length * step
        loss = _loss(rows, goal, weight, ab)
    return float(ab[0]), float(ab[1])


def _loss(rows: Tensor, goal: Tensor, weight: Tensor, ab: Tensor) -> Tensor:
    """Cross entropy of the smoothed targets: `-goal log p - (1 - goal) log(1 - p)`."""
    z = rows @ ab
    return (weight * (torch.logaddexp(torch.zeros_like(z), z) - goal * z)).sum()
