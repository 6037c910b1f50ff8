"""Objects by their faces: every piece of a plane, and whatever hangs together beside them."""

from __future__ import annotations

from dataclasses import dataclass

import torch
from torch import Tensor

from blockstab.observation import Observation
from blockstab.proposals import Proposed
from blockstab.segments.atoms import absorb_small, make_atoms
from blockstab.segments.pieces import connected_pieces
from blockstab.segments.segmentation import Segmentation

GROUND_ID = 1


@dataclass(frozen=True)
class Planes:
    """A region for every connected piece of a plane, and for every connected piece of what lies on no plane.

    The ground plane is one region, known as background. Of a box there are as many regions as faces are seen, for a
    search to merge; atoms stay whole, each on the plane of most of its pixels.

    Args:
        least_px: a smaller region joins the neighbour behind its weakest border; where it has none, it is no
            region.
        ground_share: a plane is the ground if such a share of its pixels lies in the ground plane.
    """

    least_px: int = 200
    ground_share: float = 0.5

    def __post_init__(self) -> None:
        if not 0.0 < self.ground_share <= 1.0:
            raise ValueError(
                f"The ground_share is a part of a plane, above 0 and up to 1, but it is {self.ground_share}; "
                "choose one in between."
            )

    def __call__(self, observation: Observation) -> Proposed:
        """Divide the image."""
        atoms = make_atoms(observation.fine, observation.boundary_map.strength)
        ground = self._ground(observation)
        # What lies on no plane makes regions too, so it needs a label of its own.
        gathered = Segmentation.from_labels(
            atoms, torch.where(ground, 1, observation.planes.label + 2)
        ).labels(atoms)
        pieces = connected_pieces(gathered)
        if not bool(ground.any()):
            return Proposed(self._without_small(pieces, observation))
        table = gathered == torch.bincount(gathered[ground & (gathered > 0)]).argmax()
        _, others = torch.unique(torch.where(table, 0, pieces), return_inverse=True)
        label = torch.where(table, GROUND_ID, torch.where(others > 0, others + GROUND_ID, 0))
        return Proposed(self._without_small(label, observation), {GROUND_ID: True})

    def _ground(self, observation: Observation) -> Tensor:
        """(H, W) bool: the planes that lie in the ground plane; none where they are smaller than a region."""
        plane = observation.planes.label
        pixels = torch.bincount(plane.flatten())
        level = (
            torch.bincount(plane[observation.on_ground], minlength=len(pixels)) > self.ground_share * pixels
        )
        ground = level[plane] & (plane > 0)
        return ground if int(ground.sum()) >= self.least_px else torch.zeros_like(ground)

    def _without_small(self, label: Tensor, observation: Observation) -> Tensor:
        merged = absorb_small(make_atoms(label, observation.boundary_map.strength), self.least_px)
        large = torch.bincount(merged.flatten()) >= self.least_px
        return torch.where(large[merged], merged, 0)
