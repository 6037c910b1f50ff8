"""One image understood, from pixels to what would fall: the whole path."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import cache
from typing import Protocol

import torch
from torch import Tensor

from blockstab.boundaries.combination import Combination, FixedWeights
from blockstab.energy import Energy, Rating
from blockstab.features.appearances import Appearances
from blockstab.features.pairwise import boundaries
from blockstab.features.unary import unary_features
from blockstab.interpretation import Interpreter
from blockstab.parsed import Parsed
from blockstab.percept import GroundFinder, estimated_ground, perceive
from blockstab.proposals import Proposal
from blockstab.reasoning import Rules
from blockstab.rgbd.frame import Frame
from blockstab.search import Problem, Search
from blockstab.segments.atoms import Atoms
from blockstab.segments.hierarchy import build_hierarchy, split
from blockstab.segments.segmentation import Segment, Segmentation
from blockstab.stability.removal import falls_if_removed
from blockstab.view import View, make_view

MIN_SEGMENT_PX = 100  # no split leaves a smaller part: so few points say little about a box


class Judge(Protocol):
    """A learned potential that can also say how probable it is that something is wrong."""

    def __call__(self, features: Tensor) -> Tensor: ...

    def badness(self, features: Tensor) -> Tensor: ...


class Potentials(Protocol):
    """The potentials a parse needs, and where they came from."""

    @property
    def unary(self) -> Judge: ...
    @property
    def pairwise(self) -> Judge: ...
    @property
    def merge(self) -> Judge: ...
    @property
    def name(self) -> str: ...
    @property
    def sha256(self) -> str: ...


@dataclass(frozen=True)
class Parser:
    """Turns an image into segments, boxes, supports and what would fall.

    Args:
        proposal: gives the first segmentation.
        search: improves it.
        potentials: learned judgements of segments and boundaries.
        rules: how a segmentation is understood.
        ground_of: finds the ground: `estimated_ground` or `given_ground`.
        boundaries: weighs the signs of an edge between two objects.
        seed: of the search.
    """

    proposal: Proposal
    search: Search
    potentials: Potentials
    rules: Rules = field(default_factory=Rules)
    ground_of: GroundFinder = estimated_ground
    boundaries: Combination = field(default_factory=FixedWeights)
    seed: int = 0

    @property
    def settings(self) -> str:
        """All that decides a result beside the image, in words."""
        parts = (
            self.proposal,
            self.search,
            self.potentials.sha256,
            self.rules,
            self.ground_of.__name__,
            self.boundaries,
            self.seed,
        )
        return " ".join(str(part) for part in parts)

    def __call__(self, frame: Frame) -> Parsed:
        """Understand one image."""
        seconds: dict[str, float] = {}
        with _timed(seconds, "segments"):
            view = make_view(perceive(frame, self.ground_of, self.boundaries), self.proposal)
        with _timed(seconds, "search"):
            problem = self.problem(view)
            generator = torch.Generator().manual_seed(self.seed)
            found = self.search(view.start, problem, generator)
        with _timed(seconds, "removal"):
            scene = found.best.scene
            slack = self.rules.support.noise(scene.boxes)
            table = falls_if_removed(
                scene.boxes, ~scene.background, scene.candidates, scene.balance.stable, slack
            )
        ids = _ids(scene.segmentation, view)
        return Parsed(
            name=frame.name,
            frame=frame,
            cloud=view.percept.cloud,
            label=_painted(scene.segmentation, view.atoms, ids),
            scene=scene,
            ids=ids,
            unary=found.best.unary,
            pairwise=_by_pair(found.best),
            badness=self.potentials.unary.badness(unary_features(scene)),
            falls={i: tuple(row.nonzero()[:, 0].tolist()) for i, row in enumerate(table)},
            energy=found.best.energy,
            trace=found.trace,
            seconds=seconds,
            potentials_name=self.potentials.name,
            potentials_sha256=self.potentials.sha256,
            seed=self.seed,
        )

    def problem(self, view: View) -> Problem:
        """What a search on this image may ask."""
        percept, atoms = view.percept, view.atoms
        interpret = Interpreter(percept.cloud, view.sight, percept.ground, atoms, self.rules, view.known)
        hierarchy = build_hierarchy(atoms)

        @cache
        def split_once(segment: Segment) -> tuple[Segment, Segment] | None:
            parts = split(segment, atoms, hierarchy)
            sizes = [int(atoms.pixels[list(part)].sum()) for part in parts or ()]
            return parts if min(sizes, default=0) >= MIN_SEGMENT_PX else None

        energy = Energy(self.potentials.unary, self.potentials.pairwise, Appearances(percept, atoms))
        return Problem(interpret, energy, self.potentials.merge, split_once)


def _ids(segmentation: Segmentation, view: View) -> tuple[int, ...]:
    """A segment that is just a proposed region keeps its id; the others are numbered after the largest."""
    kept = dict(zip(view.start.segments, _region_ids(view), strict=True))
    free = max(kept.values()) + 1
    ids = []
    for segment in segmentation.segments:
        ids.append(kept.get(segment, free))
        free += segment not in kept
    return tuple(ids)


def _region_ids(view: View) -> list[int]:
    """The proposal's id of each segment of the start."""
    of_atom = torch.zeros(len(view.atoms), dtype=torch.long)
    inside = view.atoms.label > 0
    of_atom[view.atoms.label[inside] - 1] = view.label[inside]
    return [int(of_atom[min(segment)]) for segment in view.start.segments]


def _painted(segmentation: Segmentation, atoms: Atoms, ids: tuple[int, ...]) -> Tensor:
    """(H, W) the label image with these ids."""
    return torch.tensor([0, *ids])[segmentation.labels(atoms)]


def _by_pair(rating: Rating) -> Tensor:
    """(M,) the potential of every bordering pair of the scene; NaN where background takes part."""
    scene = rating.scene
    table = torch.full((len(scene), len(scene)), float("nan"), dtype=torch.float64)
    larger, smaller = boundaries(scene)
    table[larger, smaller] = table[smaller, larger] = rating.pairwise
    bordering = scene.pairs.neighbours
    return table[scene.pairs.first[bordering], scene.pairs.second[bordering]]


@contextmanager
def _timed(seconds: dict[str, float], stage: str) -> Iterator[None]:
    begin = time.perf_counter()
    yield
    seconds[stage] = time.perf_counter() - begin
