"""Random moves that lead away from segmentations, for examples of what a search may meet (paper, section 7.1)."""

from __future__ import annotations

from collections.abc import Sequence

import torch

from blockstab.energy import Rating
from blockstab.search.moves import Move
from blockstab.search.problem import Problem


def walks(
    starts: Sequence[Rating], problem: Problem, moves: Sequence[Move], steps: int, generator: torch.Generator
) -> list[Rating]:
    """The segmentations on random walks, one from each start: at each step a kind of move, drawn alike, then a move.

    The walks go in step, so that what all of them come to is worked out in one batch.
    """
    now, visited = list(starts), list[Rating]()
    for _ in range(steps):
        drawn = torch.randint(len(moves), (len(now),), generator=generator).tolist()
        results = [moves[kind](one, problem, 1, generator)[:1] for kind, one in zip(drawn, now, strict=True)]
        moved = [k for k, result in enumerate(results) if result]
        for k, rating in zip(moved, problem.rate([results[k][0] for k in moved]), strict=True):
            now[k] = rating
            visited.append(rating)
    return visited
