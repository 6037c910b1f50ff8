"""Training a potential with Lightning: all rows at once, L-BFGS (paper, section 7.1)."""

from __future__ import annotations

import logging
import warnings
from collections.abc import Iterator, Sequence
from contextlib import contextmanager

import pytorch_lightning as pl
import torch
from pytorch_lightning.callbacks import EarlyStopping
from torch import Tensor
from torch.utils.data import DataLoader

from blockstab.determinism.threads import one_thread
from models.potentials.heads import HeadFactory, Potential, compressed, initialised
from models.potentials.losses import svr_objective


class PotentialFit(pl.LightningModule):
    """Minimise the objective of support vector regression over the head of one potential.

    A batch is (standardised features, target, weight) and must be the whole training set: L-BFGS
    compares gradients between steps, which only means something on the same rows.

    Args:
        potential: its head is trained in place.
        c: inverse strength of the penalty on the head's parameters, see `svr_objective`.
        iterations: of L-BFGS in one epoch, each with a line search that finds its own step.
    """

    def __init__(self, potential: Potential, c: float, iterations: int = 20) -> None:
        super().__init__()
        self.head = potential.head
        self.c = c
        self.iterations = iterations

    def training_step(self, batch: tuple[Tensor, Tensor, Tensor], _index: int) -> Tensor:
        standard, target, weight = batch
        objective = svr_objective(self.head(standard), target, weight, self.head.parameters(), self.c)
        self.log("objective", objective, on_step=False, on_epoch=True, batch_size=len(target))
        return objective

    def configure_optimizers(self) -> torch.optim.Optimizer:
        return torch.optim.LBFGS(
            self.head.parameters(),
            max_iter=self.iterations,
            tolerance_grad=1e-9,
            tolerance_change=1e-12,
            line_search_fn="strong_wolfe",
        )


def train_potential(
    features: Tensor,
    target: Tensor,
    weight: Tensor,
    columns: Sequence[str],
    head: HeadFactory,
    c: float,
    epochs: int,
    seed: int,
) -> Potential:
    """A potential standardised on these rows and trained on them, by one thread; not yet calibrated.

    Args:
        features: (N, F) raw, finite.
        target: (N,) badness, from 0 to 1.
        weight: (N,) of each row in the loss.
        columns: names of the F features.
        head: makes the head from F.
        c: see `svr_objective`.
        epochs: at most; training ends when the objective no longer falls.
        seed: decides the head's first parameters, and with them everything.
    """
    features = features.double()
    unit = features.abs().median(dim=0).values
    near = compressed(features, unit)
    mean, scale = near.mean(dim=0), near.std(dim=0, correction=0)
    # A constant column says nothing, at whatever scale: one keeps it finite.
    scale = torch.where(scale > 1e-10 * mean.abs(), scale, 1.0)
    potential = Potential(columns, initialised(head, len(columns), seed), mean, scale, unit=unit)
    rows = (potential.standardised(features), target.double(), weight)
    grown = potential.head.grown(*rows, c, seed)
    if grown is not None:
        potential.head = grown
        return potential
    with quiet_lightning(), one_thread():
        trainer = quiet_trainer(epochs, EarlyStopping("objective", min_delta=1e-6, patience=2))
        # A list of one batch is all that this loader asks of a data set.
        trainer.fit(PotentialFit(potential, c), DataLoader([rows], batch_size=None))  # type: ignore[arg-type]
    return potential


def quiet_trainer(epochs: int, *callbacks: pl.Callback) -> pl.Trainer:
    """A trainer on this processor that writes nothing, neither files nor lines."""
    return pl.Trainer(
        accelerator="cpu",
        max_epochs=epochs,
        logger=False,
        enable_checkpointing=False,
        enable_progress_bar=False,
        enable_model_summary=False,
        callbacks=list(callbacks),
    )


@contextmanager
def quiet_lightning() -> Iterator[None]:
    """Keep Lightning from announcing the hardware, and its own use of deprecated calls, at every fold."""
    logger = logging.getLogger("pytorch_lightning")
    level = logger.level
    logger.setLevel(logging.ERROR)
    try:
        with warnings.catch_warnings():
            warnings.filterwarnings("ignore", message=".*LeafSpec")
            yield
    finally:
        logger.setLevel(level)
