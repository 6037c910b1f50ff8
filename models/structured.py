"""Learning from whole segmentations: the truth must have less energy than whatever a search visits."""

from __future__ import annotations

from collections.abc import Sequence

import pytorch_lightning as pl
import torch
from torch import Tensor, nn
from torch.utils.data import DataLoader

from blockstab.energy.overlap import expected_loss
from blockstab.threads import one_thread
from models.examples import States
from models.heads import Potential
from models.training import quiet_lightning

EPOCHS = 4
LEARNING_RATE = 1e-3
_SCALE = 20.0  # energies are shares of all pixels, of which objects cover a small part


class StructuredFit(pl.LightningModule):
    """A margin between the truth and every visited segmentation that grows with its error (Taskar et al. 2003).

    The loss of an image is the mean of `max(0, E(truth) + error - E(visited))`, `error` being the true loss of the
    visited one less the truth's, with the squared error of the unary potentials beside it, so that they stay what
    they are: estimates of the loss of each segment.

    Args:
        unary, pairwise: trained in place where they follow a gradient.
        columns: (F,) and (G,) int64, which of the columns of `States` they take.
        weight: of boundaries at the beginning, above 0.
    """

    def __init__(
        self, unary: Potential, pairwise: Potential, columns: tuple[Tensor, Tensor], weight: float = 0.05
    ) -> None:
        super().__init__()
        self.unary, self.pairwise, self.columns = unary, pairwise, columns
        self.log_weight = nn.Parameter(torch.tensor(weight, dtype=torch.float64).log())

    @property
    def weight(self) -> Tensor:
        """Of boundaries, above 0."""
        return self.log_weight.exp()

    def training_step(self, batch: States, _index: int) -> Tensor:
        """The loss of one image."""
        phi = self.unary(batch.unary[:, self.columns[0]].double())
        psi = self.pairwise(batch.pairwise[:, self.columns[1]].double())
        loss = _SCALE * margin_loss(expected_loss(batch.parts, phi, psi, self.weight), batch.error)
        objects = ~batch.parts.background
        area = batch.parts.area[objects]
        kept = (area * (phi[objects] - batch.loss[objects]).square()).sum() / area.sum()
        total: Tensor = loss + kept
        self.log("objective", total, batch_size=1)
        return total

    def transfer_batch_to_device(self, batch: States, _device: torch.device, _index: int) -> States:
        """As it is: Lightning would refuse the frozen dataclass in it."""
        return batch

    def configure_optimizers(self) -> torch.optim.Optimizer:
        """Adam; the weight of boundaries is one number, and learns faster than the heads."""
        slow = {"params": [p for p in self.parameters() if p is not self.log_weight], "lr": LEARNING_RATE}
        return torch.optim.Adam([slow, {"params": [self.log_weight], "lr": 20 * LEARNING_RATE}])


def margin_loss(energy: Tensor, error: Tensor) -> Tensor:
    """Mean of `max(0, E(truth) + error - E(visited))`; the truth comes first in (S,) energies and (S,) errors."""
    short = (energy[0] - energy[1:]) + (error[1:] - error[0])
    return short.clamp(min=0).mean() if len(short) else energy.sum() * 0.0


def fit_structured(
    unary: Potential, pairwise: Potential, columns: tuple[Tensor, Tensor], states: Sequence[States], seed: int
) -> float:
    """Train both potentials further, in place, and give the weight of boundaries; one image a step, by one thread.

    Heads without a gradient stay as they are, and the weight alone is learned.
    """
    for potential in (unary, pairwise):
        for parameter in potential.parameters():
            parameter.requires_grad_(True)
    fit = StructuredFit(unary, pairwise, columns)
    order = torch.randperm(len(states), generator=torch.Generator().manual_seed(seed))
    with quiet_lightning(), one_thread():
        trainer = pl.Trainer(
            accelerator="cpu",
            max_epochs=EPOCHS,
            logger=False,
            enable_checkpointing=False,
            enable_progress_bar=False,
            enable_model_summary=False,
        )
        rows = [states[k] for k in order.tolist()]
        trainer.fit(fit, DataLoader(rows, batch_size=None))  # type: ignore[arg-type]
    for potential in (unary, pairwise):
        potential.requires_grad_(False)
    return float(fit.weight.detach())
