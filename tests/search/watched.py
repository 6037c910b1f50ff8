"""A search problem on a photograph that keeps account of what it is asked."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cache
from typing import cast

import torch
from torch import Tensor

from blockstab.boxes.fitting import Fits, MinimumSurface
from blockstab.energy.overlap import ExpectedOverlap
from blockstab.interpretation import Interpreter
from blockstab.pool import Pool
from blockstab.reasoning import Rules
from blockstab.scene import Scene
from blockstab.search.problem import EnergyFactory, Potentials, Problem, problem_of
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
    """A problem; what was interpreted, call by call; and the fitter."""

    problem: Problem
    interpreter: Interpreter
    fitter: CountingFitter
    interpreted: list[list[Segmentation]]


@cache
def blocks_view() -> View:
    """The blocks on the table, their true labels as the start."""
    return view_of(photograph(*BLOCKS))


def in_scene(potentials: Potentials, view: View) -> ExpectedOverlap:
    """The expected overlap by segments in their scene alone, and without caution."""
    return ExpectedOverlap(potentials.unary, potentials.pairwise, potentials.weight)


def watched(view: View, energy: EnergyFactory = in_scene, pool: Pool | None = None) -> Watched:
    """A fresh problem on the view."""
    fitter = CountingFitter()
    problem = problem_of(view, Rules(fitter=fitter), toy_potentials(), energy, pool)
    inner, interpreted = problem.interpret, list[list[Segmentation]]()

    def interpret(segmentations: Sequence[Segmentation]) -> list[Scene]:
        interpreted.append(list(segmentations))
        return inner(segmentations)

    interpret.in_box = inner.in_box  # type: ignore[attr-defined]
    seen = cast(Interpreter, interpret)
    return Watched(replace(problem, interpret=seen), inner, fitter, interpreted)


def seeded(seed: int) -> torch.Generator:
    """A generator of its own."""
    return torch.Generator().manual_seed(seed)
