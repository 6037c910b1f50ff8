"""R-Samp: a pool of segmentations, improved by random splits and merges (paper, Algorithm 2)."""

from __future__ import annotations

from dataclasses import dataclass, field

import torch

from blockstab.energy import Rating
from blockstab.search import Found, Problem, Search
from blockstab.search.greedy import Greedy
from blockstab.search.moves import merge_moves, split_moves
from blockstab.segments.segmentation import Segmentation


@dataclass(frozen=True)
class RSamp:
    """Algorithm 2. It starts where another search ends; the paper's choice is its Stability row.

    Args:
        moves_per_kind: N: splits, and as many merges, tried from each particle.
        pool_size: K: particles kept.
        rounds: M.
        patience: stop when the best has not changed for so many rounds.
        first: the search whose result is the first particle.
    """

    moves_per_kind: int = 5
    pool_size: int = 5
    rounds: int = 15
    patience: int = 5
    first: Search = field(default_factory=Greedy)

    def __call__(self, start: Segmentation, problem: Problem, generator: torch.Generator) -> Found:
        """Search from `start`; every draw comes from `generator`."""
        before = self.first(start, problem, generator)
        pool, trace = [before.best], list(before.trace)
        seen, unchanged = {before.best.scene.segmentation}, 0
        for _ in range(self.rounds):
            proposed = dict.fromkeys(
                move for particle in pool for move in self._moves(particle, problem, generator)
            )
            new = [segmentation for segmentation in proposed if segmentation not in seen]
            seen.update(new)
            best = pool[0]
            # `sorted` keeps the order of equals, so that a tie does not depend on anything but the draws.
            pool = sorted([*pool, *problem.energy(problem.interpret(new))], key=lambda rating: rating.energy)
            pool = pool[: self.pool_size]
            trace.append(pool[0].energy)
            unchanged = unchanged + 1 if pool[0] is best else 0
            if unchanged == self.patience:
                break
        return Found(pool[0], tuple(trace))

    def _moves(self, particle: Rating, problem: Problem, generator: torch.Generator) -> list[Segmentation]:
        return [
            *split_moves(particle, problem.split, self.moves_per_kind, generator),
            *merge_moves(particle, self.moves_per_kind, generator),
        ]
