"""R-Samp: a pool of segmentations, improved by random moves (paper, Algorithm 2)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import chain

import torch

from blockstab.energy import Rating
from blockstab.search import Search, SearchResult, rank
from blockstab.search.best_cut import BestCut
from blockstab.search.combining import combined
from blockstab.search.moves import Move
from blockstab.search.moves.every import EVERY
from blockstab.search.none import NoSearch
from blockstab.search.problem import Problem
from blockstab.segments.segmentation import Segmentation


@dataclass(frozen=True)
class RSamp:
    """Algorithm 2 with any moves; the paper's are splits and merges.

    Args:
        moves: kinds of moves, each tried from each particle.
        moves_per_kind: N: how many of each kind are tried.
        pool_size: K: particles kept.
        rounds: M.
        patience: stop when the best has not changed for so many rounds.
        at_once: moves of one round that each lower a particle's energy and change different segments are tried
            together too, at most so many; 1, as in the paper: none are.
        first: the searches whose results are the first particles; the paper's choice is its Stability row.
    """

    moves: Sequence[Move] = EVERY
    moves_per_kind: int = 2
    pool_size: int = 3
    rounds: int = 12
    patience: int = 4
    at_once: int = 16
    first: Sequence[Search] = (NoSearch(), BestCut())

    def __call__(self, start: Segmentation, problem: Problem, generator: torch.Generator) -> SearchResult:
        """Search from `start`; every draw comes from `generator`."""
        pool = [search(start, problem, generator).best for search in self.first]
        seen = {particle.scene.segmentation for particle in pool}
        pool = sorted(pool, key=rank)[: self.pool_size]
        best, unchanged = [pool[0]], 0
        for _ in range(self.rounds):
            tried = list(chain(*self._tried(pool, problem, seen, generator)))
            # `sorted` keeps the order of equals, so that a tie does not depend on anything but the draws.
            pool = sorted([*pool, *tried], key=rank)[: self.pool_size]
            unchanged = unchanged + 1 if pool[0] is best[-1] else 0
            best.append(pool[0])
            if unchanged == self.patience:
                break
        return SearchResult.of(best)

    def _tried(
        self, pool: list[Rating], problem: Problem, seen: set[Segmentation], generator: torch.Generator
    ) -> tuple[list[Rating], list[Rating]]:
        """New segmentations a move away from particles, and those that several moves at once lead to; now seen."""
        origin = dict[Segmentation, int]()
        for k, particle in enumerate(pool):
            for move in self.moves:
                for result in move(particle, problem, self.moves_per_kind, generator):
                    if result not in seen:
                        origin.setdefault(result, k)
        single = problem.rate(list(origin))
        children = list[list[Rating]]([] for _ in pool)
        for rating, k in zip(single, origin.values(), strict=True):
            children[k].append(rating)
        joint = [combined(*family, self.at_once) for family in zip(pool, children, strict=True)]
        seen.update(origin)
        new = dict.fromkeys(one for one in joint if one is not None and one not in seen)
        seen.update(new)
        return single, problem.rate(list(new)) if new else []
