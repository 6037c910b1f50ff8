"""The expected loss of overlap: what Table 4 scores, with its sign turned."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Protocol

import torch
from torch import Tensor

from blockstab.energy import Potential, Rating, asked
from blockstab.energy.caution import Caution
from blockstab.features.columns import LONE_COLUMNS, SEGMENT_COLUMNS
from blockstab.features.description import Described
from blockstab.features.pairwise import neighbour_pairs
from blockstab.proposals.search_input import SearchInput
from blockstab.scene.types import Scene

CAUTION = 0.1
TURNING = 0.3


def free(scene: Scene) -> float:
    """No price."""
    return 0.0


@dataclass(frozen=True)
class ExpectedOverlap:
    """The expected share of pixels that a segmentation loses, weighted as Eq. 5's score weighs them.

    A segment s of a(s) pixels loses `a(s) phi(s)`, where phi estimates 1 - overlap (Eq. 5); background loses the
    pixels in it that are expected to lie on things. The sum is divided by all pixels, which every segmentation of an
    image has in common, so it does not depend on how many pieces the wrong part lies in. With the true overlap as
    phi, the truth has the least energy of all.

    Boundaries add `weight` times the mean of their potentials, each by the pixels of its smaller segment: what a
    wrong boundary costs.

    Args:
        unary, pairwise: the potentials of segments and of boundaries.
        weight: of the boundaries; 0 leaves them out. A 0-d tensor may carry a gradient.
        price: what is added for leaving the start.
    """

    unary: Potential
    pairwise: Potential
    weight: float | Tensor = 0.0
    price: Callable[[Scene], float] = free

    def __call__(self, scenes: Sequence[Described]) -> list[Rating]:
        """Rate scenes."""
        unary = asked(self.unary, [one.unary for one in scenes])
        pairwise = asked(self.pairwise, [one.pairwise for one in scenes])
        return [
            Rating(
                one.scene,
                phi,
                psi,
                expected_loss(parts_of(one), phi, psi, self.weight) + self.price(one.scene),
            )
            for one, phi, psi in zip(scenes, unary, pairwise, strict=True)
        ]


@dataclass(frozen=True)
class Parts:
    """Terms of the expected loss of a segmentation beside potentials; or of several, one after the other.

    Args:
        area: (N,) float64 pixels of each segment.
        background: (N,) bool; lost: (N,) float64 share of things in it, if it is background.
        smaller: (M,) float64 pixels of the smaller side of each boundary.
        segment_of: (N,) int64, and boundary_of: (M,) int64, the segmentation that each belongs to.
        count: of segmentations.
    """

    area: Tensor
    background: Tensor
    lost: Tensor
    smaller: Tensor
    segment_of: Tensor
    boundary_of: Tensor
    count: int = 1


def parts_of(one: Described) -> Parts:
    """Of one scene."""
    scene, area = one.scene, one.scene.pixel_count.double()
    smaller = area[neighbour_pairs(scene)[1]]
    first, of_boundaries = (torch.zeros(len(rows), dtype=torch.int64) for rows in (area, smaller))
    return Parts(area, scene.background, one.lost, smaller, first, of_boundaries)


def expected_loss(parts: Parts, unary: Tensor, pairwise: Tensor, weight: float | Tensor) -> Tensor:
    """The energies of segmentations, (S,), from the potentials of their segments (N,) and boundaries (M,).

    A single one comes as a 0-d tensor.
    """
    zeros = torch.zeros(parts.count, dtype=torch.float64)
    loss = parts.area * torch.where(parts.background, parts.lost, unary.clamp(0.0, 1.0))
    between = parts.smaller * pairwise.clamp(0.0, 1.0)
    total = zeros.index_add(0, parts.segment_of, parts.area)
    lost = zeros.index_add(0, parts.segment_of, loss)
    wrong = zeros.index_add(0, parts.boundary_of, between)
    energies = (lost + weight * wrong) / total
    return energies[0] if parts.count == 1 else energies


class _Judges(Protocol):
    @property
    def unary(self) -> Potential: ...
    @property
    def alone(self) -> Potential: ...


class _Learned(_Judges, Protocol):
    @property
    def pairwise(self) -> Potential: ...
    @property
    def weight(self) -> float: ...


@dataclass(frozen=True)
class TwoJudges:
    """The mean of what two potentials say of a segment: one sees it in its scene, one by itself.

    A search finds what a potential is wrong about. Two that look at different things are seldom wrong about the
    same, and their mean is harder to fool than either.

    Args:
        learned: the potentials; `alone` takes the columns `LONE_COLUMNS`, which are among those of `unary`.
    """

    learned: _Judges

    def __call__(self, features: Tensor) -> Tensor:
        """Potentials (N,), 0 to 1, of columns `SEGMENT_COLUMNS`."""
        both = self.learned.unary(features), self.learned.alone(features[:, _LONE])
        return torch.stack(both).clamp(0.0, 1.0).mean(dim=0)


_LONE = torch.tensor([SEGMENT_COLUMNS.index(name) for name in LONE_COLUMNS])


def expected_overlap(
    potentials: _Learned, search_input: SearchInput, caution: float = CAUTION, turning: float = TURNING
) -> ExpectedOverlap:
    """The energy of an image with learned potentials, which leaves the start of the image with caution."""
    price = Caution(search_input.start, search_input.atoms.pixel_count.tolist(), caution, turning)
    return ExpectedOverlap(TwoJudges(potentials), potentials.pairwise, potentials.weight, price)
