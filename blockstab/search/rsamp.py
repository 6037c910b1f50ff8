"""R-Samp: a pool of segmentations, improved by random moves (paper, Algorithm 2)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import torch

from blockstab.search import Found, Search, rank
from blockstab.search.best_cut import BestCut
from blockstab.search.moves import Move
from blockstab.search.moves.every import EVERY
from blockstab.search.problem import Problem
from blockstab.search.stay import Stay
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
        first: the searches whose results are the first particles; the paper's choice is its Stability row.
    """

    moves: Sequence[Move] = EVERY
    moves_per_kind: int = 2
    pool_size: int = 3
    rounds: int = 12
    patience: int = 4
    first: Sequence[Search] = (Stay(), BestCut())

    def __call__(self, start: Segmentation, problem: Problem, generator: torch.Generator) -> Found:
        """Search from `start`; every draw comes from `generator`."""
        pool = [search(start, problem, generator).best for search in self.first]
        seen = {particle.scene.segmentation for particle in pool}
        pool = sorted(pool, key=rank)[: self.pool_size]
        best, unchanged = [pool[0]], 0
        for _ in range(self.rounds):
            proposed = dict.fromkeys(
                result
                for particle in pool
                for move in self.moves
                for result in move(particle, problem, self.moves_per_kind, generator)
            )
            new = [segmentation for segmentation in proposed if segmentation not in seen]
            seen.update(new)
            # `sorted` keeps the order of equals, so that a tie does not depend on anything but the draws.
            pool = sorted([*pool, *problem.rate(new)], key=rank)[: self.pool_size]
            unchanged = unchanged + 1 if pool[0] is best[-1] else 0
            best.append(pool[0])
            if unchanged == self.patience:
                break
        return Found.of(best)
