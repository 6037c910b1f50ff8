"""A search problem on a photograph that keeps account of what it is asked."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cache
from typing import cast

import torch
from torch import Tensor

from blockstab.boxes.box import Boxes
from blockstab.boxes.fitting import Fits, MinimumSurface
from blockstab.energy.overlap import ExpectedOverlap
from blockstab.proposals.pool import Pool
from blockstab.proposals.search_input import SearchInput
from blockstab.scene.builder import SceneBuilder
from blockstab.scene.inference import Rules
from blockstab.scene.types import Scene
from blockstab.search.problem import EnergyFactory, Potentials, Problem, problem_of
from blockstab.segments.segmentation import Segmentation
from blockstab.stability.judges import TrimmedSupports, Verdicts
from blockstab.stability.support import Supports
from blockstab.testing.photographs import BLOCKS, photograph
from tests.synthetic import view_of
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

    def coarser(self, times: float) -> CountingFitter:
        """Itself: the tests are seen by a Kinect."""
        assert times == 1.0
        return self

    def __call__(self, points: Tensor, count: Tensor, seed: Tensor, axis: Tensor | None = None) -> Fits:
        """Fit, and keep account."""
        (self.free if axis is None else self.refits).append(len(points))
        return self.inner(points, count, seed, axis)


@dataclass(frozen=True)
class CountingJudge:
    """The paper's rule, and how many boxes it was asked about in each call."""

    asked: list[int] = field(default_factory=list)

    def __call__(self, boxes: Boxes, movable: Tensor, candidates: Supports, slack: Tensor) -> Verdicts:
        """Judge, and keep account."""
        self.asked.append(int(movable.sum()))
        return TrimmedSupports()(boxes, movable, candidates, slack)


@dataclass(frozen=True)
class Watched:
    """A problem; what was interpreted, call by call; and the fitter."""

    problem: Problem
    builder: SceneBuilder
    fitter: CountingFitter
    interpreted: list[list[Segmentation]]


@cache
def blocks_view() -> SearchInput:
    """The blocks on the table, their true labels as the start."""
    return view_of(photograph(*BLOCKS))


def in_scene(potentials: Potentials, search_input: SearchInput) -> ExpectedOverlap:
    """The expected overlap by segments in their scene alone, and without caution."""
    return ExpectedOverlap(potentials.unary, potentials.pairwise, potentials.weight)


def watched(search_input: SearchInput, energy: EnergyFactory = in_scene, pool: Pool | None = None) -> Watched:
    """A fresh problem on the view."""
    fitter = CountingFitter()
    problem = problem_of(search_input, Rules(fitter=fitter), toy_potentials(), energy, pool)
    inner, interpreted = problem.build, list[list[Segmentation]]()

    def build(segmentations: Sequence[Segmentation]) -> list[Scene]:
        interpreted.append(list(segmentations))
        return inner(segmentations)

    build.in_box = inner.in_box  # type: ignore[attr-defined]
    seen = cast(SceneBuilder, build)
    return Watched(replace(problem, build=seen), inner, fitter, interpreted)


def seeded(seed: int) -> torch.Generator:
    """A generator of its own."""
    return torch.Generator().manual_seed(seed)
