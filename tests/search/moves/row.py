"""A table and three blocks in a row, whose potentials are given, for moves that ask nothing of an image."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from dataclasses import replace
from types import SimpleNamespace
from typing import cast

import torch

from blockstab.energy import Rating
from blockstab.search.problem import Problem
from blockstab.segments.segmentation import Segment, Segmentation
from blockstab.testing.worlds import Block
from tests.box_scene import scene_of

TABLE = Block(0, -0.1, 4.0, 0.1, d=4.0, fixed=True)
ROW = (TABLE, *(Block(0.3 * k, 0, 0.1, 0.1) for k in range(3)))
PAIRS = [frozenset({2 * k, 2 * k + 1}) for k in range(4)]  # atoms of the table and the three blocks
DRAWS = 6000
SHARES = [0.05 / 1.65, 0.55 / 1.65, 1.05 / 1.65]  # for potentials 0, 1/2 and 1: linear, but never zero


def rated(unary: list[float], pairwise: list[float], segments: list[Segment] | None = None) -> Rating:
    """The table and three blocks with these potentials; two atoms each unless `segments` says otherwise."""
    scene = replace(scene_of(*ROW), segmentation=Segmentation(tuple(segments or PAIRS)))
    return Rating(scene, torch.tensor(unary), torch.tensor(pairwise), torch.tensor(0.0))


def halves(segment: Segment) -> tuple[Segment, Segment] | None:
    """Its first atom, and the others."""
    first = frozenset({min(segment)})
    return first, segment - first


def splitting(how: Callable[[Segment], tuple[Segment, Segment] | None] = halves) -> Problem:
    """A problem that knows how segments fall apart, and nothing else."""
    return cast(Problem, SimpleNamespace(split=how))


def shares(results: list[Segmentation], outcomes: list[Segmentation]) -> list[float]:
    """How often each outcome was drawn; nothing else may have been."""
    counted = Counter(results)
    assert counted.keys() <= set(outcomes)
    return [counted[outcome] / len(results) for outcome in outcomes]
