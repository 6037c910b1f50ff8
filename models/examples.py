"""Training rows: what segmentations look like that a search may meet, and how much of the truth each part loses."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import NamedTuple

import torch
from torch import Tensor

from blockstab.boundaries.combination import Combination, FixedWeights
from blockstab.energy.overlap import Parts, expected_loss, expected_overlap, parts_of
from blockstab.energy.recording import Recorder
from blockstab.features.description import Described
from blockstab.features.pairwise import boundaries
from blockstab.percept import estimated_ground, perceive
from blockstab.pool import NoMasks, Pool
from blockstab.proposals import Proposal
from blockstab.reasoning import Rules
from blockstab.rgbd.frame import Frame
from blockstab.search import Search
from blockstab.search.moves import Move
from blockstab.search.problem import Potentials, Problem, problem_of
from blockstab.search.truth import true_segmentation
from blockstab.segments.overlap import Overlap
from blockstab.segments.segmentation import Segment
from blockstab.view import View, make_view
from models.perturbing import walk

KINDS = ("unary", "pairwise", "alone", "background")
GOOD_OVERLAP = 0.9  # "a positive training sample if score(s) >= 90%"


class Rows(NamedTuple):
    """Features (N, F) float32, their targets (N,) float64, and pixels (N,) float64 that they stand for.

    A target is a loss between 0, good, and 1, bad.
    """

    features: Tensor
    target: Tensor
    pixels: Tensor


class States(NamedTuple):
    """Whole segmentations of one image: S of them, N segments and M boundaries in all.

    Args:
        unary: (N, F); pairwise: (M, G) float32.
        loss: (N,) the true loss of each segment.
        error: (S,) the true loss of each segmentation; the first is the truth.
        parts: what their energies need beside potentials.
    """

    unary: Tensor
    pairwise: Tensor
    loss: Tensor
    error: Tensor
    parts: Parts


class Examples(NamedTuple):
    """Rows for each potential, and whole segmentations for the structured loss."""

    unary: Rows
    pairwise: Rows
    alone: Rows
    background: Rows
    states: States


class Neutral(NamedTuple):
    """Potentials that find everything alike: with them, moves are drawn without preference."""

    weight: float = 0.0

    @staticmethod
    def unary(rows: Tensor) -> Tensor:
        return torch.full((len(rows),), 0.5, dtype=torch.float64)

    pairwise = alone = background = unary


@dataclass(frozen=True)
class ExampleMaker:
    """Makes the examples of one image (paper, section 7.1).

    The truth, drawn on atoms, and the start of each proposal are led astray by random moves; with potentials, a
    search adds what it visits. A segment loses what its overlap lacks to 1 (Eq. 5), against true objects alone; a
    boundary, the more of its two sides; background, the things in it.

    Args:
        proposals: segmentations as they come in practice.
        moves: kinds of moves, as the search has them.
        search: with potentials, what is visited from each start; None for random walks alone.
        potentials: those of the round before; neutral where None.
        rules: how a segmentation is understood.
        boundaries: weighs the signs of an edge between two objects.
        pool: offers masks.
        walks, steps: random walks from the truth, and as many from each start, and their length.
        most_states: whole segmentations kept of each proposal.
        most_masks: masks of the pool that are looked at by themselves.
    """

    proposals: Sequence[Proposal]
    moves: Sequence[Move]
    search: Search | None = None
    potentials: Potentials | None = None
    rules: Rules = field(default_factory=Rules)
    boundaries: Combination = field(default_factory=FixedWeights)
    pool: Pool = field(default_factory=NoMasks)
    walks: int = 4
    steps: int = 6
    most_states: int = 24
    most_masks: int = 250

    def __call__(self, frame: Frame, generator: torch.Generator) -> Examples:
        """Examples from one image.

        Raises:
            ValueError: if the image has no labels.
        """
        if frame.label is None:
            raise ValueError(f"{frame.name} has no label.png; training needs the true segments.")
        percept = perceive(frame, estimated_ground, self.boundaries)
        return joined([self._of_view(make_view(percept, proposal), generator) for proposal in self.proposals])

    def _of_view(self, view: View, generator: torch.Generator) -> Examples:
        potentials, seen = self.potentials or Neutral(), list[Described]()

        def recording(learned: Potentials, of: View) -> Recorder:
            return Recorder(expected_overlap(learned, of), lambda scene, _: seen.append(scene))

        problem = problem_of(view, self.rules, potentials, recording, self.pool)
        truth, start = problem.rate([true_segmentation(problem), view.start])
        if self.search is not None and self.potentials is not None:
            self.search(view.start, problem, generator)
        else:
            for origin in (truth, start):
                for _ in range(self.walks):
                    walk(origin, problem, self.moves, self.steps, generator)
        return self._examples(view, problem, seen, generator)

    def _examples(
        self, view: View, problem: Problem, seen: list[Described], generator: torch.Generator
    ) -> Examples:
        frame = view.percept.frame
        assert frame.label is not None
        overlap = Overlap(view.atoms, frame.label, frame.background_ids)
        # The truth and the start come first, and are always kept.
        kept = [0, 1, *(2 + k for k in _some(len(seen) - 2, self.most_states - 2, generator))]
        seen = [seen[k] for k in kept if k < len(seen)]
        lone = dict.fromkeys(s for one in seen for s in one.scene.segmentation.segments)
        masks = problem.masks
        lone.update(dict.fromkeys(masks[k] for k in _some(len(masks), self.most_masks, generator)))
        atoms = [frozenset({atom}) for atom in range(len(view.atoms))]

        def rows(segments: list[Segment], target: Tensor) -> Rows:
            size = torch.tensor([problem.pixels(s) for s in segments], dtype=torch.float64)
            return Rows(problem.describe.lone(segments).float(), target, size)

        return Examples(
            *_new_rows(seen, overlap),
            rows(list(lone), 1.0 - overlap.best(list(lone))),
            rows(atoms, overlap.thing_share(atoms)),
            _states(seen, overlap),
        )


def _new_rows(seen: Sequence[Described], overlap: Overlap) -> tuple[Rows, Rows]:
    """Rows of the objects, and of the boundaries, that no segmentation before had."""
    unary, pairwise = list[Rows](), list[Rows]()
    segments, pairs = set[Segment](), set[frozenset[Segment]]()
    for one in seen:
        scene = one.scene
        parts, area = scene.segmentation.segments, scene.pixels.double()
        loss = 1.0 - overlap.best(parts)
        new = [
            k
            for k, (s, apart) in enumerate(zip(parts, scene.background.tolist(), strict=True))
            if not apart and s not in segments
        ]
        unary.append(Rows(one.unary[new].float(), loss[new], area[new]))
        segments.update(parts[k] for k in new)
        first, second = boundaries(scene)
        both = [frozenset({parts[a], parts[b]}) for a, b in zip(first.tolist(), second.tolist(), strict=True)]
        fresh = [k for k, pair in enumerate(both) if pair not in pairs]
        target = torch.maximum(loss[first], loss[second])[fresh]
        pairwise.append(Rows(one.pairwise[fresh].float(), target, area[second][fresh]))
        pairs.update(both)
    return joined_rows(unary), joined_rows(pairwise)


def _states(seen: Sequence[Described], overlap: Overlap) -> States:
    parts, losses, errors = list[Parts](), list[Tensor](), list[Tensor]()
    for one in seen:
        segments = one.scene.segmentation.segments
        own = replace(parts_of(one), lost=overlap.thing_share(segments))
        losses.append(1.0 - overlap.best(segments))
        psi = torch.zeros(len(own.smaller), dtype=torch.float64)
        errors.append(expected_loss(own, losses[-1], psi, 0.0))
        parts.append(parts_of(one))
    return States(
        torch.cat([one.unary for one in seen]).float(),
        torch.cat([one.pairwise for one in seen]).float(),
        torch.cat(losses),
        torch.stack(errors),
        joined_parts(parts),
    )


def joined_rows(parts: Sequence[Rows]) -> Rows:
    """The rows of all parts, in order."""
    return Rows(*(torch.cat(columns) for columns in zip(*parts, strict=True)))


def joined_parts(parts: Sequence[Parts]) -> Parts:
    """Several segmentations as one table."""
    start = torch.tensor([0, *(p.count for p in parts)]).cumsum(0).tolist()
    return Parts(
        *(torch.cat([getattr(p, name) for p in parts]) for name in ("area", "background", "lost", "smaller")),
        torch.cat([p.segment_of + k for p, k in zip(parts, start, strict=False)]),
        torch.cat([p.boundary_of + k for p, k in zip(parts, start, strict=False)]),
        start[-1],
    )


def joined(parts: Sequence[Examples]) -> Examples:
    """The examples of all parts, in order; of whole segmentations, the truth of the first part comes first."""
    states = [p.states for p in parts]
    return Examples(
        *(joined_rows([getattr(p, kind) for p in parts]) for kind in KINDS),
        States(
            *(
                torch.cat([getattr(s, name) for s in states])
                for name in ("unary", "pairwise", "loss", "error")
            ),
            joined_parts([s.parts for s in states]),
        ),
    )


def _some(count: int, most: int, generator: torch.Generator) -> list[int]:
    """At most so many of the numbers below `count`, in order."""
    chosen: list[int] = torch.randperm(max(count, 0), generator=generator)[:most].sort().values.tolist()
    return chosen
