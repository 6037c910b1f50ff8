"""One image understood, from pixels to what would fall: the whole path."""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Protocol

import torch
from torch import Tensor

from blockstab.boundaries.edge_models import EdgeModel, FixedWeights
from blockstab.determinism.fingerprint import fingerprint
from blockstab.energy import Rating
from blockstab.energy.overlap import expected_overlap
from blockstab.features.columns import SegmentColumns
from blockstab.features.pairwise import neighbour_pairs
from blockstab.observation import GroundFinder, estimated_ground
from blockstab.parsing.collecting import uncollected
from blockstab.parsing.look import Look
from blockstab.parsing.parsed import Parsed
from blockstab.parsing.taken_away import removal_of
from blockstab.proposals import Proposal, stamp_of
from blockstab.proposals.pool import Pool, Regions
from blockstab.proposals.search_input import SearchInput
from blockstab.rgbd.frame import Frame
from blockstab.scene.conclusions import Concluding, WhatStands
from blockstab.scene.inference import Rules
from blockstab.search import Search, SearchResult, rank
from blockstab.search.problem import EnergyFactory, Potentials, Problem, problem_of
from blockstab.segments.atoms import Atoms
from blockstab.segments.segmentation import Segment, Segmentation


class CalibratedPotential(Protocol):
    """A learned potential that can also say how probable it is that something is wrong."""

    def __call__(self, features: Tensor) -> Tensor: ...

    def badness(self, features: Tensor) -> Tensor: ...


class NamedPotentials(Potentials, Protocol):
    """Potentials of a search, that say how sure they are and where they came from."""

    @property
    def unary(self) -> CalibratedPotential: ...
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
        edges: weighs the cues of an edge between two objects.
        energy: makes, from the potentials, what the search lowers.
        pool: offers masks to the search.
        columns: of segments, beside ours, that the potentials ask for.
        concluding: says in the end what stands, and what must be there unseen.
        seed: of the search.
    """

    proposal: Proposal
    search: Search
    potentials: NamedPotentials
    rules: Rules = field(default_factory=Rules)
    ground_of: GroundFinder = estimated_ground
    edges: EdgeModel = field(default_factory=FixedWeights)
    energy: EnergyFactory = expected_overlap
    pool: Pool = field(default_factory=Regions)
    columns: Sequence[SegmentColumns] = ()
    concluding: Concluding = field(default_factory=WhatStands)
    seed: int = 0

    @property
    def fingerprint(self) -> str:
        """Fingerprint, in one word, of all that decides a result beside the image: settings, potentials, code."""
        return fingerprint(self)

    def stamp(self, scene: str) -> str:
        """A word that changes whenever the files do that are read for a scene beside its image."""
        stamps = stamp_of(self.proposal, scene), stamp_of(self.pool, scene)
        return " ".join(stamps) if any(stamps) else ""

    def __call__(self, frame: Frame) -> Parsed:
        """Understand one image."""
        return self.understand(Look(frame))

    def understand(self, look: Look) -> Parsed:
        """Understand one image, of which other parsers may have computed something already."""
        problem, found, seconds = self.search_in(look)
        with _timed(seconds, "conclusion"):
            concluded = self.concluding(found.best.scene, problem.build)
        with _timed(seconds, "removal"):
            removal = removal_of(concluded.scene, problem.build.rules)
        scene, search_input = concluded.scene, problem.search_input
        ids = _ids(scene.segmentation, search_input)
        return Parsed(
            name=look.frame.name,
            frame=look.frame,
            cloud=search_input.observation.cloud,
            label=_painted(scene.segmentation, search_input.atoms, ids),
            scene=scene,
            ids=ids,
            unary=found.best.unary.detach(),
            pairwise=_by_pair(found.best),
            badness=self.potentials.unary.badness(problem.describe([found.best.scene])[0].unary),
            seen=concluded.seen,
            verdict=concluded.verdict,
            unseen=concluded.unseen,
            removal=removal,
            judge=type(problem.build.rules.judge).__name__,
            energy=rank(found.best),
            trace=found.trace,
            seconds=seconds,
            potentials_name=self.potentials.name,
            potentials_sha256=self.potentials.sha256,
            seed=self.seed,
        )

    def search_in(self, look: Look) -> tuple[Problem, SearchResult, dict[str, float]]:
        """The problem of the search, its result, and the seconds that each stage took."""
        search_input, seconds = look.search_input(self.ground_of, self.edges, self.proposal)
        masks, seconds["pool"] = look.masks(self.pool, search_input)
        with _timed(seconds, "search"), uncollected():
            problem = self.problem(search_input, masks)
            generator = torch.Generator().manual_seed(self.seed)
            found = self.search(search_input.start, problem, generator)
        return problem, found, seconds

    def problem(self, search_input: SearchInput, masks: Sequence[Segment] | None = None) -> Problem:
        """The problem of a search on this image; `masks` are those of the pool, where they are known."""
        pool = self.pool if masks is None else lambda _: masks
        return problem_of(search_input, self.rules, self.potentials, self.energy, pool, self.columns)


def _ids(segmentation: Segmentation, search_input: SearchInput) -> tuple[int, ...]:
    """A segment that is just a proposed region keeps its id; the others are numbered after the largest."""
    kept = dict(zip(search_input.start.segments, _region_ids(search_input), strict=True))
    free = max(kept.values()) + 1
    ids = []
    for segment in segmentation.segments:
        ids.append(kept.get(segment, free))
        free += segment not in kept
    return tuple(ids)


def _region_ids(search_input: SearchInput) -> list[int]:
    """The proposal's id of each segment of the start."""
    of_atom = torch.zeros(len(search_input.atoms), dtype=torch.long)
    inside = search_input.atoms.label > 0
    of_atom[search_input.atoms.label[inside] - 1] = search_input.label[inside]
    return [int(of_atom[min(segment)]) for segment in search_input.start.segments]


def _painted(segmentation: Segmentation, atoms: Atoms, ids: tuple[int, ...]) -> Tensor:
    """(H, W) the label image with these ids."""
    return torch.tensor([0, *ids])[segmentation.labels(atoms)]


def _by_pair(rating: Rating) -> Tensor:
    """(M,) the potential of every bordering pair of the scene; NaN where background takes part."""
    scene = rating.scene
    table = torch.full((len(scene), len(scene)), float("nan"), dtype=torch.float64)
    larger, smaller = neighbour_pairs(scene)
    table[larger, smaller] = table[smaller, larger] = rating.pairwise
    bordering = scene.pairs.neighbours
    return table[scene.pairs.first[bordering], scene.pairs.second[bordering]]


@contextmanager
def _timed(seconds: dict[str, float], stage: str) -> Iterator[None]:
    begin = time.perf_counter()
    yield
    seconds[stage] = time.perf_counter() - begin
