"""Cut a part of the hierarchy off a segment, and leave it alone or hand it to a neighbour."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import partial

from blockstab.energy import Rating
from blockstab.search.moves.drawing import Change, MostPromising
from blockstab.search.problem import Problem
from blockstab.segments.segmentation import Segment, Segmentation


@dataclass(frozen=True)
class Cut(MostPromising):
    """Any node of the hierarchy that lies within an object becomes an object; never of background."""

    def changes(self, rating: Rating, problem: Problem) -> list[Change]:
        """All cuts."""
        now = rating.scene.segmentation
        return [
            Change((whole,), parts, partial(now.replace, i, parts))
            for i, whole, parts in inner_nodes(rating, problem)
        ]


@dataclass(frozen=True)
class Transfer(MostPromising):
    """Any node of the hierarchy at the border of an object goes over to a neighbouring object."""

    def changes(self, rating: Rating, problem: Problem) -> list[Change]:
        """All transfers."""
        now, touching = rating.scene.segmentation, problem.touching
        owner = {
            atom: i
            for i, (s, apart) in enumerate(zip(now.segments, rating.scene.background.tolist(), strict=True))
            if not apart
            for atom in s
        }
        changes = []
        for i, whole, (node, rest) in inner_nodes(rating, problem):
            beside = {owner[b] for a in node for b in touching[a] if b in owner} - {i}
            for j in sorted(beside):
                other = now.segments[j]
                result = partial(_handed, now, i, j, node)
                changes.append(Change((whole, other), (rest, other | node), result))
        return changes


def _handed(now: Segmentation, i: int, j: int, node: Segment) -> Segmentation:
    """The part `node` of segment i goes over to segment j."""
    other = now.segments[j]
    cut = now.replace(i, (node, now.segments[i] - node))
    return cut.merge(cut.segments.index(node), cut.segments.index(other))


def inner_nodes(rating: Rating, problem: Problem) -> Iterator[tuple[int, Segment, tuple[Segment, Segment]]]:
    """Every way to part an object into a node of the hierarchy and the rest: index, object, its two parts."""
    segments = rating.scene.segmentation.segments
    for i, (whole, apart) in enumerate(zip(segments, rating.scene.background.tolist(), strict=True)):
        if not apart:
            yield from ((i, whole, parts) for parts in problem.nodes_in(whole))
