"""Carve a mask of the pool out of whatever it lies in."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial

from blockstab.energy import Rating
from blockstab.search.moves.drawing import Change, MostPromising
from blockstab.search.problem import Problem
from blockstab.segments.segmentation import Segment


@dataclass(frozen=True)
class Carve(MostPromising):
    """A mask becomes an object, and the segments that it cuts, background too, give way."""

    def changes(self, rating: Rating, problem: Problem) -> list[Change]:
        """All carvings."""
        now = rating.scene.segmentation
        objects = {
            s for s, apart in zip(now.segments, rating.scene.background.tolist(), strict=True) if not apart
        }
        cut = dict[Segment, list[tuple[Segment, Segment]]]()
        for segment in now.segments:
            for mask, left in problem.masks_in(segment).items():
                cut.setdefault(mask, []).append((segment, left))
        changes = []
        for mask in problem.masks:
            if mask not in objects:
                cuts = cut.get(mask, ())
                new = (mask, *(left for _, left in cuts if left))
                gone = tuple(segment for segment, _ in cuts)
                changes.append(Change(gone, new, partial(now.carve, mask), frozenset({mask})))
        return changes
