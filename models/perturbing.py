"""Random moves that lead away from a segmentation, for examples of what a search may meet (paper, section 7.1)."""

from __future__ import annotations

from collections.abc import Sequence

import torch

from blockstab.energy import Rating
from blockstab.search.moves import Move
from blockstab.search.problem import Problem


def walk(
    start: Rating, problem: Problem, moves: Sequence[Move], steps: int, generator: torch.Generator
) -> list[Rating]:
    """The segmentations on a random walk: at each step a kind of move, drawn alike, then one of its moves."""
    now, visited = start, list[Rating]()
    for _ in range(steps):
        move = moves[int(torch.randint(len(moves), (1,), generator=generator))]
        results = move(now, problem, 1, generator)
        if results:
            (now,) = problem.rate(results[:1])
            visited.append(now)
    return visited
