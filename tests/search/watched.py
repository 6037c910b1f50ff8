"""A search problem on a photograph that keeps account of what it is asked."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cache

import torch
from torch import Tensor

from blockstab.boxes.fitting import Fits, MinimumSurface
from blockstab.interpretation import Interpreter, Rules
from blockstab.parser import Parser
from blockstab.proposals.files import LabelFile
from blockstab.scene import Scene
from blockstab.search import Problem
from blockstab.search.stay import Stay
from blockstab.segments.segmentation import Segmentation
from blockstab.view import View
from tests.synthetic import BLOCKS, photograph, view_of
from tests.toy_potentials import toy_potentials


@dataclass(frozen=True)
class CountingFitter:
    """Minimum surface fits; for each call, how many boxes were fitted, and whether to an axis."""

    inner: MinimumSurface = field(default_factory=MinimumSurface)
    free: list[int] = field(default_factory=list)
    refits: list[int] = field(default_factory=list)

    @property
    def max_points(self) -> int:
        """As the inner one."""
        return self.inner.max_points

    def __call__(self, points: Tensor, count: Tensor, seed: Tensor, axis: Tensor | None = None) -> Fits:
        """Fit, and keep account."""
        (self.free if axis is None else self.refits).append(len(points))
        return self.inner(points, count, seed, axis)


@dataclass(frozen=True)
class Watched:
    """A problem; what was interpreted and how many merges were judged, call by call; and the fitter."""

    problem: Problem
    interpreter: Interpreter
    fitter: CountingFitter
    interpreted: list[list[Segmentation]]
    judged: list[int]


@cache
def blocks_view() -> View:
    """The blocks on the table, their true labels as the start."""
    return view_of(photograph(*BLOCKS))


def watched(view: View) -> Watched:
    """A fresh problem on the view."""
    fitter = CountingFitter()
    problem = Parser(LabelFile(), Stay(), toy_potentials(), Rules(fitter=fitter)).problem(view)
    interpreted: list[list[Segmentation]] = []
    judged: list[int] = []

    def interpret(segmentations: Sequence[Segmentation]) -> list[Scene]:
        interpreted.append(list(segmentations))
        return problem.interpret(segmentations)

    def merge(rows: Tensor) -> Tensor:
        judged.append(len(rows))
        return problem.merge(rows)

    return Watched(
        replace(problem, interpret=interpret, merge=merge), problem.interpret, fitter, interpreted, judged
    )


def seeded(seed: int) -> torch.Generator:
    """A generator of its own."""
    return torch.Generator().manual_seed(seed)
