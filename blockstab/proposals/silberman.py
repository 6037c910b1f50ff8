"""The segmentation of Silberman et al. (2012): atoms merged in stages by learned judgements of their borders."""

from __future__ import annotations

import heapq
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Literal, Protocol

import torch
import torch.nn.functional as F
from torch import Tensor

from blockstab.features.appearance.pair_columns import Variant, edgelet_appearance
from blockstab.features.appearance.regions import viewed_regions
from blockstab.features.appearance.views import view
from blockstab.observation import Observation
from blockstab.proposals import Proposed
from blockstab.segments.atoms import absorb_small, make_atoms
from blockstab.segments.edgelets import Edgelets, trace_edgelets

Order = Literal["best", "random"]


class Stage(Protocol):
    """One round of merging: what is known of borders is learned anew for the larger regions of each."""

    @property
    def threshold(self) -> float:
        """Regions are merged while this or more is the least confidence along their border."""

    def __call__(self, appearance: Tensor, /) -> Tensor:
        """Confidence (L,) from 0 to 1 that edgelets, described by (L, 51) features, lie within one object."""


class Stages(Protocol):
    """The stages in order, and the variant of the features that they were trained on."""

    @property
    def variant(self) -> Variant: ...

    @property
    def stages(self) -> Sequence[Stage]: ...


@dataclass(frozen=True)
class Silberman:
    """Merge atoms over several stages (Silberman et al. 2012, section 4).

    In a stage every edgelet is judged once; the border of two regions is as sure to be none as its least sure
    edgelet says, so that one strong edgelet holds the two apart. Regions are merged while any border reaches the
    stage's threshold. Then borders are traced anew.

    Args:
        learned: the stages.
        order: "best": the surest border first; "random": any that reaches the threshold, as in the authors'
            program, drawn from a generator that is seeded by `seed`.
        least_px: a smaller region joins, in the end, the neighbour behind its weakest border; 0 keeps all.
        background_share: a region of which such a share is in the ground plane is known as background.
    """

    learned: Stages
    order: Order = "best"
    seed: int = 0
    least_px: int = 200
    background_share: float = 0.5

    def __post_init__(self) -> None:
        if self.order not in ("best", "random"):
            raise ValueError(f"The order of merging is best or random, but it is {self.order!r}; choose one.")

    def __call__(self, observation: Observation) -> Proposed:
        """Divide the image."""
        label, views = observation.fine, view(observation)
        generator = torch.Generator().manual_seed(self.seed)
        for stage in self.learned.stages:
            edgelets, regions = trace_edgelets(label), viewed_regions(views, label)
            rows = edgelet_appearance(regions, edgelets, observation.boundary_map, self.learned.variant)
            label = merged_once(label, edgelets, stage(rows), stage.threshold, self.order, generator)
        label = absorb_small(make_atoms(label, observation.boundary_map.strength), self.least_px)
        pixels = torch.bincount(label.flatten())
        ground = torch.bincount(label[observation.on_ground], minlength=len(pixels))
        flat = (ground > self.background_share * pixels).nonzero()[:, 0].tolist()
        return Proposed(label, {region: True for region in flat if region > 0})


def merged_once(
    label: Tensor,
    edgelets: Edgelets,
    within: Tensor,
    threshold: float,
    order: Order,
    generator: torch.Generator,
) -> Tensor:
    """The regions (H, W) that one stage makes of those of `label`, numbered from 1 without gaps.

    Args:
        edgelets: of `label`.
        within: confidence (L,) that each lies within one object.
        threshold: regions are merged while this or more is the least confidence along their border.
    """
    if not len(edgelets.first):
        return label
    draw: Callable[[float], float] = (
        (lambda sure: -sure)
        if order == "best"
        else lambda _: float(torch.rand(1, generator=generator, dtype=torch.float64))
    )
    owner = _owners(int(label.max()), edgelets, within, threshold, draw)
    number = torch.unique(torch.tensor(owner), return_inverse=True)[1] + 1
    return F.pad(number, (1, 0))[label]


def _owners(
    count: int, edgelets: Edgelets, within: Tensor, threshold: float, turn: Callable[[float], float]
) -> list[int]:
    """For each of `count` regions, the one that it becomes part of; borders of least `turn` go first."""
    sure: list[dict[int, float]] = [{} for _ in range(count)]
    for i, j, value in zip(edgelets.first.tolist(), edgelets.second.tolist(), within.tolist(), strict=True):
        sure[i][j] = sure[j][i] = min(value, sure[i].get(j, 1.0))
    queue = [
        (turn(value), i, j, value)
        for i, row in enumerate(sure)
        for j, value in row.items()
        if i < j and value >= threshold
    ]
    heapq.heapify(queue)
    owner = list(range(count))
    while queue:
        _, kept, gone, value = heapq.heappop(queue)
        # Of a border that has changed since, only the latest entry counts.
        if owner[kept] != kept or owner[gone] != gone or sure[kept].get(gone) != value:
            continue
        owner[gone] = kept
        del sure[kept][gone]
        for other, least in sure[gone].items():
            if other == kept:
                continue
            del sure[other][gone]
            pooled = min(least, sure[kept].get(other, 1.0))
            if sure[kept].get(other) != pooled:
                sure[kept][other] = sure[other][kept] = pooled
                if pooled >= threshold:
                    heapq.heappush(queue, (turn(pooled), min(kept, other), max(kept, other), pooled))
        sure[gone] = {}
    for region in range(count):
        while owner[owner[region]] != owner[region]:
            owner[region] = owner[owner[region]]
    return owner
