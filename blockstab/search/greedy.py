"""Greedy merging, the paper's Stability row (section 6.1)."""

from __future__ import annotations

from dataclasses import dataclass

import torch

from blockstab.features.pairwise import pairs_of
from blockstab.search import SearchResult, rank
from blockstab.search.problem import Problem
from blockstab.segments.segmentation import Pair, Segment, Segmentation


@dataclass(frozen=True)
class Greedy:
    """Merge the two neighbours that lower the energy most, until none does."""

    def __call__(self, start: Segmentation, problem: Problem, generator: torch.Generator) -> SearchResult:
        """Merge from `start`; nothing is drawn at random."""
        best, gain, current = problem.rate([start]), dict[Pair, float](), set[Pair]()
        while True:
            now = best[-1]
            pairs = pairs_of(now.scene)
            fresh = [pair for pair in pairs if pair not in gain]
            after = problem.rate([_merged(now.scene.segmentation, pair) for pair in fresh])
            gain.update((pair, rank(now) - rank(one)) for pair, one in zip(fresh, after, strict=True))
            current.update(fresh)
            chosen = max(pairs, key=lambda pair: gain[pair], default=None)
            if chosen is None or gain[chosen] <= 0:
                if current.issuperset(pairs):
                    return SearchResult.of(best)
                # Far merges may change what a pair gains, as where an energy is a mean: the rest is judged anew.
                gain = {pair: gain[pair] for pair in current}
                continue
            (merged,) = problem.rate([_merged(now.scene.segmentation, chosen)])
            if rank(merged) >= rank(now):
                gain[chosen] = rank(now) - rank(merged)
                current.add(chosen)
                continue
            changed = set(chosen) | _neighbours(pairs, chosen)
            gain = {pair: value for pair, value in gain.items() if not changed & set(pair)}
            current.clear()
            best.append(merged)


def _neighbours(pairs: list[Pair], chosen: Pair) -> set[Segment]:
    return {segment for pair in pairs if set(chosen) & set(pair) for segment in pair}


def _merged(segmentation: Segmentation, pair: Pair) -> Segmentation:
    return segmentation.merge(segmentation.segments.index(pair[0]), segmentation.segments.index(pair[1]))
