"""From labelled rows to a calibrated potential, and the choice of its C (paper, section 7.1)."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from typing import NamedTuple

import torch
from joblib import delayed
from rich.console import Console
from rich.progress import track
from torch import Tensor

from blockstab.determinism.threads import one_thread
from blockstab.executors import each_done
from models.potentials.calibration import platt
from models.potentials.heads import HeadFactory, Potential, initialised
from models.potentials.losses import balanced_weights, squared_epsilon_insensitive
from models.potentials.rows import GOOD
from models.potentials.training import train_potential

FOLDS = 5
EPOCHS = 10  # of 20 iterations: a linear head is at its optimum by then, a network near one


class CrossFit(NamedTuple):
    """A potential, and those that had not seen some of the images.

    Args:
        potential: of all rows, calibrated.
        unseen: for each fold, a potential of the other folds' images, not calibrated; `fold_of` tells the fold.
        held_out: (N,) of each row, from the potential that had not seen its image.
    """

    potential: Potential
    unseen: tuple[Potential, ...]
    held_out: Tensor


def fold_of(groups: Tensor, folds: int) -> Tensor:
    """The fold of each image, (N,): in turn, so that sets that follow each other are shared out evenly."""
    return groups % folds


def cross_fit(
    features: Tensor,
    target: Tensor,
    groups: Tensor,
    columns: Sequence[str],
    head: HeadFactory,
    *,
    c: float,
    weight: Tensor | None = None,
    bad: Tensor | None = None,
    epochs: int = EPOCHS,
    folds: int = FOLDS,
    seed: int = 0,
    jobs: int = 1,
) -> CrossFit:
    """Train a potential on all rows, and calibrate it on potentials from fits that had not seen the row.

    Args:
        features: (N, F) raw, finite.
        target: (N,) badness, from 0 to 1; good and bad rows must occur.
        groups: (N,) int64, the image a row comes from; a fold never divides an image.
        columns: names of the F features.
        head: `LinearHead`, `MLPHead`, a partial of one, or a class of your own.
        c: inverse strength of the penalty, see `svr_objective`; `choose_c` finds it.
        weight: (N,) of each row in the loss; where None, good and bad rows count the same.
        bad: (N,) bool, what calibration tells from good; where None, a target above `GOOD`.
        epochs: at most; training ends when the objective no longer falls.
        folds: how many parts calibration makes of the images.
        seed: decides the head's first parameters, and with them everything.
        jobs: fits side by side; no number depends on it.

    Returns:
        Potentials whose parameters ask for no gradient.

    Raises:
        ValueError: naming what is wrong with the rows.
    """
    weight = _checked_weights(features, target, groups, columns, folds, weight)
    fit = partial(train_potential, columns=columns, head=head, c=c, epochs=epochs, seed=seed)
    everything = torch.ones(len(target), dtype=torch.bool)
    trains = [everything, *(~fold for fold in _folds(groups, folds))]
    potential, *unseen = _side_by_side([fit], features, target, weight, trains, jobs)
    held_out = _held_out(unseen, features, groups, folds)
    with one_thread():
        a, b = platt(held_out, (target > GOOD if bad is None else bad).double())
    potential.a.fill_(a)
    potential.b.fill_(b)
    return CrossFit(potential, tuple(unseen), held_out)


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
    """The C with the least loss on held-out images, the smaller of equals; the rest as in `cross_fit`."""
    weight = _checked_weights(features, target, groups, columns, folds, weight)
    grid = sorted(grid or initialised(head, len(columns), seed).grid)
    if len(grid) == 1:
        return ChosenC(grid[0], {})
    fits = [partial(train_potential, columns=columns, head=head, c=c, epochs=epochs, seed=seed) for c in grid]
    trains = [~fold for fold in _folds(groups, folds)]
    fitted = _side_by_side(fits, features, target, weight, trains, jobs)
    losses = {
        c: float(
            squared_epsilon_insensitive(
                _held_out(fitted[k * folds : (k + 1) * folds], features, groups, folds), target, weight
            )
        )
        for k, c in enumerate(grid)
    }
    return ChosenC(min(losses, key=losses.__getitem__), losses)


_Fit = Callable[[Tensor, Tensor, Tensor], Potential]


def _folds(groups: Tensor, folds: int) -> list[Tensor]:
    """(N,) bool for each fold, the rows of its images."""
    return [fold_of(groups, folds) == k for k in range(folds)]


def _held_out(unseen: Sequence[Potential], features: Tensor, groups: Tensor, folds: int) -> Tensor:
    """(N,) potentials of all rows, each from the potential that had not seen its image."""
    potentials = torch.empty(len(features), dtype=torch.float64)
    for potential, fold in zip(unseen, _folds(groups, folds), strict=True):
        potentials[fold] = potential(features[fold])
    return potentials


def _side_by_side(
    fits: Sequence[_Fit],
    features: Tensor,
    target: Tensor,
    weight: Tensor,
    trains: Sequence[Tensor],
    jobs: int,
) -> list[Potential]:
    """For each way to fit, a potential of each choice of rows."""
    work = [delayed(_fitted)(fit, features[t], target[t], weight[t]) for fit in fits for t in trains]
    done = each_done(work, jobs)
    console = Console(stderr=True)
    return list(
        track(done, "fits", len(work), transient=True, console=console, disable=not console.is_terminal)
    )


def _fitted(fit: _Fit, features: Tensor, target: Tensor, weight: Tensor) -> Potential:
    return fit(features, target, weight).requires_grad_(False)


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
