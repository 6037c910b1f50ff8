"""The best cut of the merge tree, by dynamic programming on segments judged by themselves."""

from __future__ import annotations

from dataclasses import dataclass

import torch

from blockstab.search import SearchResult
from blockstab.search.problem import Problem
from blockstab.segments.hierarchy import nodes
from blockstab.segments.segmentation import Segment, Segmentation


@dataclass(frozen=True)
class BestCut:
    """Of all ways to cut the hierarchy, the one whose segments lose least by themselves.

    A node of the hierarchy is kept whole if it loses no more than the best cut of the two parts that it was made
    from. What is background stays as it is in the start, and no node reaches into it.
    """

    def __call__(self, start: Segmentation, problem: Problem, generator: torch.Generator) -> SearchResult:
        """The cut, rated; nothing is drawn at random."""
        (rating,) = problem.rate([start])
        kept = {
            s: True
            for s, apart in zip(start.segments, rating.scene.background.tolist(), strict=True)
            if apart
        }
        free = frozenset(a for s in start.segments if s not in kept for a in s)
        parts = _best_parts(problem, free)
        cut = Segmentation(tuple(sorted([*kept, *parts], key=min))).telling(kept)
        return SearchResult.of([rating, *problem.rate([cut])])


def _best_parts(problem: Problem, free: Segment) -> list[Segment]:
    """The parts of the best cut of what the hierarchy's nodes have among some atoms."""
    found = [node & free for node in nodes(problem.hierarchy)]
    some = [node for node in dict.fromkeys(found) if node]
    loss = {frozenset(): 0.0, **dict(zip(some, problem.losses(some), strict=True))}
    hierarchy, count = problem.hierarchy, len(problem.hierarchy.borders)
    best = {atom: (loss[part], [part] if part else []) for atom, part in enumerate(found[:count])}
    merges = zip(hierarchy.first.tolist(), hierarchy.second.tolist(), found[count:], strict=True)
    for kept, gone, node in merges:
        one, other = best[kept], best.pop(gone)
        best[kept] = (one[0] + other[0], one[1] + other[1])
        if node and loss[node] <= best[kept][0]:
            best[kept] = (loss[node], [node])
    return [part for _, parts in best.values() for part in parts]
