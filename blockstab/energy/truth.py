"""The energy that knows the truth: what a search could reach with perfect potentials."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import torch

from blockstab.energy import Rating
from blockstab.energy.overlap import expected_loss, parts_of
from blockstab.features.description import Described
from blockstab.proposals.search_input import SearchInput
from blockstab.segments.overlap import Overlap


@dataclass(frozen=True)
class TrueOverlap:
    """The loss of overlap itself: 1 - overlap (Eq. 5) as the potential of a segment; nothing for boundaries."""

    overlap: Overlap

    def __call__(self, scenes: Sequence[Described]) -> list[Rating]:
        """Rate scenes."""
        ratings = []
        for one in scenes:
            segments = one.scene.segmentation.segments
            phi = 1.0 - self.overlap.best(segments)
            psi = torch.zeros(len(one.pairwise), dtype=torch.float64)
            parts = replace(parts_of(one), lost=self.overlap.thing_share(segments))
            ratings.append(Rating(one.scene, phi, psi, expected_loss(parts, phi, psi, 0.0)))
        return ratings


def true_overlap(potentials: object, search_input: SearchInput) -> TrueOverlap:
    """The energy of an image whose labels are known; ValueError without labels. Potentials are not asked."""
    frame = search_input.observation.frame
    if frame.label is None:
        raise ValueError(f"{frame.name} has no label.png; the true overlap needs one.")
    return TrueOverlap(Overlap(search_input.atoms, frame.label, frame.background_ids))
