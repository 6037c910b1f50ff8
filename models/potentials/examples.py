"""Training rows: what segmentations look like that a search may meet, and how much of the truth each part loses."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import torch
from torch import Tensor

from blockstab.boundaries.edge_models import EdgeModel, FixedWeights
from blockstab.energy import Potential, Rating
from blockstab.energy.overlap import Parts, expected_loss, expected_overlap, parts_of
from blockstab.energy.recording import Recorder
from blockstab.features.columns import SegmentColumns
from blockstab.features.description import Described
from blockstab.features.pairwise import neighbour_pairs
from blockstab.observation import estimated_ground, observe
from blockstab.proposals import Proposal
from blockstab.proposals.pool import NoMasks, Pool
from blockstab.proposals.search_input import SearchInput, make_search_input
from blockstab.rgbd.frame import Frame
from blockstab.scene.inference import Rules
from blockstab.search import Search, rank
from blockstab.search.moves import Move
from blockstab.search.problem import Potentials, Problem, problem_of
from blockstab.search.truth import true_segmentation
from blockstab.segments.overlap import Overlap
from blockstab.segments.segmentation import Segment
from models.potentials.perturbing import walks
from models.potentials.rows import GOOD, Examples, Rows, States, joined, joined_parts, joined_rows


@dataclass(frozen=True)
class Neutral:
    """Potentials that find everything alike: with them, moves are drawn without preference."""

    weight: float = 0.0

    @property
    def unary(self) -> Potential:
        return _alike

    pairwise = alone = background = unary


def _alike(rows: Tensor) -> Tensor:
    return torch.full((len(rows),), 0.5, dtype=torch.float64)


@dataclass(frozen=True)
class ExampleMaker:
    """Makes the examples of one image (paper, section 7.1).

    The truth, drawn on atoms, and the start of each proposal are led astray by random moves; with potentials, a
    search adds what it visits. A segment loses what its overlap lacks to 1 (Eq. 5), against true objects alone; a
    boundary, what its two sides would gain as one; background, the things in it. To the paper a boundary is bad if
    either side is.

    Args:
        proposals: segmentations as they come in practice.
        moves: kinds of moves, as the search has them.
        search: with potentials, what is visited from each start; None for random walks alone.
        potentials: those of the round before; neutral where None.
        rules: how a segmentation is understood.
        edges: weighs the cues of an edge between two objects.
        pool: offers masks.
        columns: of segments, beside ours.
        walks, steps: random walks from the truth, and as many from each start, and their length.
        most_states: whole segmentations kept of each proposal; the segments and boundaries of all are.
        most_masks: masks of the pool that are looked at by themselves.
    """

    proposals: Sequence[Proposal]
    moves: Sequence[Move]
    search: Search | None = None
    potentials: Potentials | None = None
    rules: Rules = field(default_factory=Rules)
    edges: EdgeModel = field(default_factory=FixedWeights)
    pool: Pool = field(default_factory=NoMasks)
    columns: Sequence[SegmentColumns] = ()
    walks: int = 8
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
        observation = observe(frame, estimated_ground, self.edges)
        return joined(
            [
                self._of_view(make_search_input(observation, proposal), generator)
                for proposal in self.proposals
            ]
        )

    def _of_view(self, search_input: SearchInput, generator: torch.Generator) -> Examples:
        potentials, seen = self.potentials or Neutral(), list[tuple[Described, Rating]]()

        def recording(learned: Potentials, of: SearchInput) -> Recorder:
            # Without caution: what a search finds so is what potentials must learn to judge.
            return Recorder(
                expected_overlap(learned, of, caution=0.0, turning=0.0), lambda *both: seen.append(both)
            )

        problem = problem_of(search_input, self.rules, potentials, recording, self.pool, self.columns)
        truth, start = problem.rate([true_segmentation(problem), search_input.start])
        if self.search is not None and self.potentials is not None:
            self.search(search_input.start, problem, generator)
        else:
            walks([truth, start] * self.walks, problem, self.moves, self.steps, generator)
        kept = _kept([rank(rating) for _, rating in seen], self.most_states, generator)
        return self._examples(search_input, problem, [scene for scene, _ in seen], kept, generator)

    def _examples(
        self,
        search_input: SearchInput,
        problem: Problem,
        seen: list[Described],
        kept: list[int],
        generator: torch.Generator,
    ) -> Examples:
        frame = search_input.observation.frame
        assert frame.label is not None
        overlap = Overlap(search_input.atoms, frame.label, frame.background_ids)
        lone = dict.fromkeys(s for one in seen for s in one.scene.segmentation.segments)
        masks = problem.masks
        lone.update(dict.fromkeys(masks[k] for k in _some(len(masks), self.most_masks, generator)))
        atoms = [frozenset({atom}) for atom in range(len(search_input.atoms))]
        whole = list(dict.fromkeys([*atoms, *lone]))

        def rows(segments: list[Segment], target: Tensor) -> Rows:
            size = torch.tensor([problem.pixel_count(s) for s in segments], dtype=torch.float64)
            return Rows(problem.describe.lone(segments).float(), target, target > GOOD, size)

        return Examples(
            *_new_rows(seen, overlap),
            rows(list(lone), 1.0 - overlap.best(list(lone))),
            rows(whole, overlap.thing_share(whole)),
            _states([seen[k] for k in kept], overlap),
        )


def _new_rows(seen: Sequence[Described], overlap: Overlap) -> tuple[Rows, Rows]:
    """Rows of the objects, and of the boundaries, that no segmentation before had."""
    unary, pairwise = list[Rows](), list[Rows]()
    segments, pairs = set[Segment](), set[frozenset[Segment]]()
    for one in seen:
        scene = one.scene
        parts, area = scene.segmentation.segments, scene.pixel_count.double()
        loss = 1.0 - overlap.best(parts)
        new = [
            k
            for k, (s, apart) in enumerate(zip(parts, scene.background.tolist(), strict=True))
            if not apart and s not in segments
        ]
        unary.append(Rows(one.unary[new].float(), loss[new], loss[new] > GOOD, area[new]))
        segments.update(parts[k] for k in new)
        first, second = neighbour_pairs(scene)
        both = [frozenset({parts[a], parts[b]}) for a, b in zip(first.tolist(), second.tolist(), strict=True)]
        fresh = [k for k, pair in enumerate(both) if pair not in pairs]
        first, second = first[fresh], second[fresh]
        unions = [parts[a] | parts[b] for a, b in zip(first.tolist(), second.tolist(), strict=True)]
        union = 1.0 - overlap.best(unions) if unions else loss[:0]
        apart = area[first] * loss[first] + area[second] * loss[second]
        gain = (apart - (area[first] + area[second]) * union) / area[second]
        bad = torch.maximum(loss[first], loss[second]) > GOOD
        pairwise.append(Rows(one.pairwise[fresh].float(), gain.clamp(0.0, 1.0), bad, area[second]))
        pairs.update(both)
    return joined_rows(unary), joined_rows(pairwise)


def _kept(energies: Sequence[float], most: int, generator: torch.Generator) -> list[int]:
    """Indices of the whole segmentations kept, in order: the first two, half of least energy, and others."""
    others = sorted(range(2, len(energies)), key=energies.__getitem__)
    most = max(most - 2, 0)
    best, rest = others[: most // 2], others[most // 2 :]
    drawn = [rest[k] for k in _some(len(rest), most - len(best), generator)]
    return [0, 1, *sorted([*best, *drawn])]


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


def _some(count: int, most: int, generator: torch.Generator) -> list[int]:
    """At most so many of the numbers below `count`, in order."""
    chosen: list[int] = torch.randperm(max(count, 0), generator=generator)[:most].sort().values.tolist()
    return chosen
