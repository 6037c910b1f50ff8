"""Split a segment where its own box does not explain its points."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import partial
from itertools import product

from torch import Tensor

from blockstab.energy import Rating
from blockstab.scene.builder import AtomsInBox
from blockstab.search.moves.drawing import Change, MostPromising
from blockstab.search.problem import MIN_SEGMENT_PX, Problem
from blockstab.segments.segmentation import Segment


@dataclass(frozen=True)
class Unexplained(MostPromising):
    """The atoms of an object that its box does not explain become an object of their own; never of background.

    They are those that lie off its faces. Or, as a box holds all of what stands before another, and the faces of the
    other lie inside it: what lies beyond such a face.

    Args:
        steps: how far off a face the points of an atom lie on average, in steps of the depth sensor.
        least_m: the same in metres; the larger counts.
    """

    steps: float = 3.0
    least_m: float = 0.01

    def changes(self, rating: Rating, problem: Problem) -> list[Change]:
        """All splits."""
        scene = rating.scene
        now, changes = scene.segmentation, []
        for i, (whole, apart) in enumerate(zip(now.segments, scene.background.tolist(), strict=True)):
            if apart or len(whole) < 2:
                continue
            for parts in problem.once((self, whole), partial(self._partings, whole, problem)):
                changes.append(Change((whole,), parts, partial(now.replace, i, parts)))
        return changes

    def _partings(self, whole: Segment, problem: Problem) -> list[tuple[Segment, Segment]]:
        """What a box does not explain of its segment, and the rest, wherever both are large enough."""
        seen = problem.build.in_box(whole)
        reach = (self.steps * seen.step).clamp(min=self.least_m)
        found = []
        for off in (seen.far > reach, *_beyond_inner_faces(seen, reach)):
            part = frozenset(atom for atom, outside in zip(seen.atoms, off.tolist(), strict=True) if outside)
            parts = (part, whole - part)
            if min(map(problem.pixel_count, parts)) >= MIN_SEGMENT_PX:
                found.append(parts)
        return found


def _beyond_inner_faces(seen: AtomsInBox, reach: Tensor) -> Iterator[Tensor]:
    """(A,) bool, for each atom off the faces that is flat like one but lies further in: the atoms before it."""
    for axis, sign in product(range(3), (1, -1)):
        place = sign * seen.middle[:, axis]
        inner = (seen.far > reach) & (seen.spread[:, axis] < reach) & (seen.half[axis] - place > reach)
        yield from (place > place[k] + reach for k in inner.nonzero()[:, 0].tolist())
