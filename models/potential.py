"""From labelled rows to a calibrated potential, and the choice of its C (paper, section 7.1)."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from typing import NamedTuple

import torch
from joblib import Parallel, delayed
from rich.console import Console
from rich.progress import track
from sklearn.model_selection import GroupKFold
from torch import Tensor

from blockstab.threads import one_thread
from models.calibration import platt
from models.heads import HeadFactory, Potential, initialised
from models.losses import balanced_weights, squared_epsilon_insensitive
from models.training import train_potential

GOOD = 0.1  # badness up to which something counts as good: an overlap of 90 % (paper, section 7.1)
FOLDS = 5
EPOCHS = 10  # of 20 iterations: a linear head is at its optimum by then, a network near one


def fit_potential(
    features: Tensor,
    target: Tensor,
    groups: Tensor,
    columns: Sequence[str],
    head: HeadFactory,
    *,
    c: float,
    weight: Tensor | None = None,
    epochs: int = EPOCHS,
    folds: int = FOLDS,
    seed: int = 0,
    jobs: int = 1,
) -> Potential:
    """Train a potential on all rows, and calibrate it on potentials from fits that had not seen the row.

    Args:
        features: (N, F) raw, finite.
        target: (N,) badness, from 0 to 1; good and bad rows must occur.
        groups: (N,) int64, the image a row comes from; a fold never divides an image.
        columns: names of the F features.
        head: `LinearHead`, `MLPHead`, a partial of one, or a class of your own.
        c: inverse strength of the penalty, see `svr_objective`; `choose_c` finds it.
        weight: (N,) of each row in the loss; where None, good and bad rows count the same.
        epochs: at most; training ends when the objective no longer falls.
        folds: how many parts calibration makes of the images.
        seed: decides the head's first parameters, and with them everything.
        jobs: fits side by side; no number depends on it.

    Returns:
        A potential whose parameters ask for no gradient.

    Raises:
        ValueError: naming what is wrong with the rows.
    """
    weight = _checked_weights(features, target, groups, columns, folds, weight)
    fit = partial(train_potential, columns=columns, head=head, c=c, epochs=epochs, seed=seed)
    (unseen,) = _unseen([fit], features, target, weight, groups, folds, jobs)
    with one_thread():
        a, b = platt(unseen, (target > GOOD).double())
    potential = fit(features, target, weight)
    potential.a.fill_(a)
    potential.b.fill_(b)
    return potential.requires_grad_(False)


class ChosenC(NamedTuple):
    c: float
    held_out_loss: dict[
        float, float
    ]  # of every C tried, on rows its fits had not seen; empty where there is one


def choose_c(
    features: Tensor,
    target: Tensor,
    groups: Tensor,
    columns: Sequence[str],
    head: HeadFactory,
    *,
    grid: Sequence[float] | None = None,
    weight: Tensor | None = None,
    epochs: int = EPOCHS,
    folds: int = FOLDS,
    seed: int = 0,
    jobs: int = 1,
) -> ChosenC:
    """The C with the least loss on held-out images, the smaller of equals; the rest as in `fit_potential`."""
    weight = _checked_weights(features, target, groups, columns, folds, weight)
    grid = sorted(grid or initialised(head, len(columns), seed).grid)
    if len(grid) == 1:
        return ChosenC(grid[0], {})
    fits = [partial(train_potential, columns=columns, head=head, c=c, epochs=epochs, seed=seed) for c in grid]
    unseen = _unseen(fits, features, target, weight, groups, folds, jobs)
    losses = {
        c: float(squared_epsilon_insensitive(potentials, target, weight))
        for c, potentials in zip(grid, unseen, strict=True)
    }
    return ChosenC(min(losses, key=losses.__getitem__), losses)


_Fit = Callable[[Tensor, Tensor, Tensor], Potential]


def _unseen(
    fits: Sequence[_Fit],
    features: Tensor,
    target: Tensor,
    weight: Tensor,
    groups: Tensor,
    folds: int,
    jobs: int,
) -> list[Tensor]:
    """For each way to fit, potentials of all rows, (N,), each from a fit to the images of the other folds."""
    splits = list(GroupKFold(folds).split(features, groups=groups))
    work = [
        delayed(_judged)(fit, features[train], target[train], weight[train], features[test])
        for fit in fits
        for train, test in splits
    ]
    done = Parallel(n_jobs=jobs, return_as="generator")(work)
    console = Console(stderr=True)
    bar = track(
        done, "cross-validation", len(work), transient=True, console=console, disable=not console.is_terminal
    )
    order = torch.cat([torch.from_numpy(test) for _, test in splits]).argsort()
    return list(torch.cat(list(bar)).view(len(fits), -1)[:, order])


def _judged(fit: _Fit, features: Tensor, target: Tensor, weight: Tensor, unseen: Tensor) -> Tensor:
    """Potentials of the rows of `unseen` from a fit to the others."""
    return fit(features, target, weight)(unseen).detach()


def _checked_weights(
    features: Tensor,
    target: Tensor,
    groups: Tensor,
    columns: Sequence[str],
    folds: int,
    weight: Tensor | None,
) -> Tensor:
    """The given or class-balancing weights, (N,), of rows that can train a potential; ValueError if they cannot."""
    rows = len(target)
    if features.shape != (rows, len(columns)) or target.shape != (rows,) or groups.shape != (rows,):
        raise ValueError(
            f"Training needs features (N, {len(columns)}), target (N,) and groups (N,), but got "
            f"{tuple(features.shape)}, {tuple(target.shape)} and {tuple(groups.shape)}."
        )
    if not bool(features.isfinite().all()):
        row, column = (~features.isfinite()).nonzero()[0].tolist()
        raise ValueError(
            f"Features must be finite, but {columns[column]} of row {row} is {features[row, column]}."
        )
    images = len(set(groups.tolist()))
    if not 2 <= folds <= images:
        raise ValueError(f"The rows of {images} images can form 2 to {images} folds, but folds is {folds}.")
    if weight is not None and weight.shape != (rows,):
        raise ValueError(f"Each of {rows} rows needs a weight, but got shape {tuple(weight.shape)}.")
    return balanced_weights(target, GOOD) if weight is None else weight
