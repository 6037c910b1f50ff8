"""Join neighbours that promise to be one thing."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial

from blockstab.energy import Rating
from blockstab.features.pairwise import neighbour_pairs
from blockstab.search.moves.drawing import Change, MostPromising
from blockstab.search.problem import Problem


@dataclass(frozen=True)
class Join(MostPromising):
    """Neighbouring objects become one, drawn by how good the union looks by itself; never background."""

    def changes(self, rating: Rating, problem: Problem) -> list[Change]:
        """All unions."""
        now = rating.scene.segmentation
        changes = []
        for i, j in zip(*(side.tolist() for side in neighbour_pairs(rating.scene)), strict=True):
            one, other = now.segments[i], now.segments[j]
            changes.append(Change((one, other), (one | other,), partial(now.merge, i, j)))
        return changes
