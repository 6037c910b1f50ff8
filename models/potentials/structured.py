"""Learning from whole segmentations: the truth must have less energy than whatever a search visits."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import pytorch_lightning as pl
import torch
from torch import Tensor, nn
from torch.utils.data import DataLoader

from blockstab.determinism.threads import one_thread
from blockstab.energy.overlap import Parts, TwoJudges, expected_loss
from models.potentials.heads import Potential
from models.potentials.parsing import ParsingPotentials
from models.potentials.rows import States
from models.potentials.training import quiet_lightning, quiet_trainer

EPOCHS = 4
LEAST_WEIGHT = 0.01  # of boundaries, to learn on from
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
        self, unary: Potential, pairwise: Potential, columns: tuple[Tensor, Tensor], weight: float
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
        energy = expected_loss(_objects(batch.parts), phi, psi, self.weight) + background_loss(batch)
        loss = _SCALE * margin_loss(energy, batch.error)
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


def background_loss(states: States) -> Tensor:
    """(S,) the true loss of each segmentation by the things in its background.

    What background potentials say of it is another question, and depends on when the states were made.
    """
    parts = _objects(states.parts)
    nothing = torch.zeros(len(parts.smaller), dtype=torch.float64)
    return states.error - expected_loss(parts, states.loss, nothing, 0.0)


def _objects(parts: Parts) -> Parts:
    """The same, where background loses nothing."""
    return replace(parts, lost=torch.zeros_like(parts.lost))


def margin_loss(energy: Tensor, error: Tensor) -> Tensor:
    """Mean of `max(0, E(truth) + error - E(visited))`; the truth comes first in (S,) energies and (S,) errors."""
    short = (energy[0] - energy[1:]) + (error[1:] - error[0])
    return short.clamp(min=0).mean() if len(short) else energy.sum() * 0.0


def fit_structured(
    unary: Potential,
    pairwise: Potential,
    columns: tuple[Tensor, Tensor],
    states: Sequence[States],
    weight: float,
    seed: int,
) -> float:
    """Train both potentials further, in place, and the weight of boundaries; one image a step, by one thread.

    Heads without a gradient stay as they are, and so does the weight.
    """
    parameters = [p for potential in (unary, pairwise) for p in potential.parameters()]
    if not parameters:
        return weight
    for parameter in parameters:
        parameter.requires_grad_(True)
    fit = StructuredFit(unary, pairwise, columns, max(weight, LEAST_WEIGHT))
    order = torch.randperm(len(states), generator=torch.Generator().manual_seed(seed))
    with quiet_lightning(), one_thread():
        rows = [states[k] for k in order.tolist()]
        quiet_trainer(EPOCHS).fit(fit, DataLoader(rows, batch_size=None))  # type: ignore[arg-type]
    for potential in (unary, pairwise):
        potential.requires_grad_(False)
    return float(fit.weight.detach())


def held_out_weight(judges: Sequence[ParsingPotentials], states: Sequence[States]) -> float:
    """The weight of boundaries with which the energy of objects follows their error best, 0 or more.

    That of least squares: error = a * (segments + weight * boundaries), whatever the image.

    Args:
        judges: of each image, potentials that have not seen it.
        states: of each image.
    """
    terms, errors = list[Tensor](), list[Tensor]()
    for judge, some in zip(judges, states, strict=True):
        phi, psi = TwoJudges(judge)(some.unary), judge.pairwise(some.pairwise)
        parts = _objects(some.parts)
        segments = expected_loss(parts, phi, psi, 0.0)
        boundaries = expected_loss(parts, phi, psi, 1.0) - segments
        both = torch.stack([segments, boundaries], dim=1).detach()
        terms.append(both - both.mean(dim=0))
        error = some.error - background_loss(some)
        errors.append(error - error.mean())
    found = torch.linalg.lstsq(torch.cat(terms), torch.cat(errors)[:, None], driver="gelsd").solution[:, 0]
    scale, weighted = found.tolist()
    return max(weighted / scale, 0.0) if scale > 0 else 0.0
