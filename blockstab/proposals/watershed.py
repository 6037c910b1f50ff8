"""Objects by their boundaries alone: atoms merged until only strong borders are left."""

from __future__ import annotations

from dataclasses import dataclass

import torch
from torch import Tensor

from blockstab.observation import Observation
from blockstab.proposals import Proposed
from blockstab.segments.atoms import absorb_small, join, make_atoms
from blockstab.segments.hierarchy import build_hierarchy

GROUND_ID = 1


@dataclass(frozen=True)
class Watershed:
    """Flood the boundary strength, then merge across borders up to a threshold.

    Pixels in the ground plane are gathered first, in one region known as background: the table stays whole,
    and joins nothing that stands on it.

    Args:
        threshold: mean strength of the strongest border that is removed, 0 to 1; lower is finer.
        least_px: a smaller region joins the neighbour behind its weakest border; where it has none, it is no
            region.
    """

    threshold: float = 0.5
    least_px: int = 200

    def __post_init__(self) -> None:
        if not 0.0 <= self.threshold <= 1.0:
            raise ValueError(
                f"The threshold is a boundary strength, between 0 and 1, but it is {self.threshold}; "
                "choose one in between, lower for smaller regions."
            )

    def __call__(self, observation: Observation) -> Proposed:
        """Divide the image."""
        strength, fine = observation.boundary_map.strength, observation.fine
        floor = observation.on_ground & (fine > 0)
        if int(floor.sum()) < self.least_px:
            return Proposed(self._without_small(self._merged(fine, strength), strength))
        parts = join(fine, torch.where(floor, GROUND_ID, 2 * (fine > 0)))
        _, others = torch.unique(torch.where(floor, 0, parts), return_inverse=True)
        objects = self._merged(others, strength)
        label = torch.where(floor, GROUND_ID, torch.where(objects > 0, objects + GROUND_ID, 0))
        return Proposed(self._without_small(label, strength), {GROUND_ID: True})

    def _merged(self, fine: Tensor, strength: Tensor) -> Tensor:
        """The regions that merging the parts of `fine` up to the threshold makes, from 1."""
        atoms = make_atoms(fine, strength)
        return build_hierarchy(atoms).cut(self.threshold).labels(atoms)

    def _without_small(self, label: Tensor, strength: Tensor) -> Tensor:
        merged = absorb_small(make_atoms(label, strength), self.least_px)
        large = torch.bincount(merged.flatten()) >= self.least_px
        return torch.where(large[merged], merged, 0)
