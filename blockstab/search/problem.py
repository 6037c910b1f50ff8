"""Problem of a search on one image: all that the search may ask about it."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, Protocol, TypeVar

from blockstab.energy import Energy, Potential, Rating
from blockstab.features.columns import SegmentColumns
from blockstab.features.description import Describer
from blockstab.proposals.pool import NoMasks, Pool
from blockstab.proposals.search_input import SearchInput
from blockstab.scene.builder import SceneBuilder
from blockstab.scene.inference import Rules
from blockstab.segments.hierarchy import Hierarchy, build_hierarchy, nodes, split
from blockstab.segments.segmentation import Segment, Segmentation

Made = TypeVar("Made")

MIN_SEGMENT_PX = 60  # no move leaves a smaller part: so few points say little about a box


class Potentials(Protocol):
    """The learned judgements that a problem needs.

    `unary` and `pairwise` judge segments and boundaries in a scene, `alone` judges a segment by itself, `background`
    tells from a segment by itself what share of it is things.
    """

    @property
    def unary(self) -> Potential: ...
    @property
    def pairwise(self) -> Potential: ...
    @property
    def alone(self) -> Potential: ...
    @property
    def background(self) -> Potential: ...
    @property
    def weight(self) -> float: ...


class EnergyFactory(Protocol):
    """Makes the energy of one image, of whose start all segments are told to be background or not."""

    def __call__(self, potentials: Potentials, search_input: SearchInput, /) -> Energy: ...


@dataclass(frozen=True)
class Problem:
    """One image, as a search sees it.

    Args:
        search_input: the image, its atoms, and where to start.
        hierarchy: the order in which its atoms merge.
        build: understands segmentations.
        describe: computes the features of scenes.
        energy: rates described scenes.
        alone: potential of segments by themselves, (S, C) columns `LONE_COLUMNS` to (S,).
        offered: masks of a pool, beside the nodes of the hierarchy.
    """

    search_input: SearchInput
    hierarchy: Hierarchy
    build: SceneBuilder
    describe: Describer
    energy: Energy
    alone: Potential
    offered: tuple[Segment, ...] = ()

    def rate(self, segmentations: Sequence[Segmentation]) -> list[Rating]:
        """Understand, describe and rate; what is new is worked out in one batch."""
        return self.energy(self.describe(self.build(segmentations)))

    def losses(self, segments: Sequence[Segment]) -> list[float]:
        """Pixels that segments are expected to lose, judged by themselves; all of too small ones."""
        known = self._losses
        new = list(dict.fromkeys(s for s in segments if s not in known))
        large = [s for s in new if self.pixel_count(s) >= MIN_SEGMENT_PX]
        share = dict[Segment, float]()
        if large:
            judged = self.alone(self.describe.lone(large)).detach().clamp(0.0, 1.0)
            share.update(zip(large, judged.tolist(), strict=True))
        known.update((s, self.pixel_count(s) * share.get(s, 1.0)) for s in new)
        return [known[s] for s in segments]

    def pixel_count(self, segment: Segment) -> int:
        """Pixel count of a segment."""
        if segment not in self._pixels:
            self._pixels[segment] = sum(map(self._atom_pixels.__getitem__, segment))
        return self._pixels[segment]

    def nodes_in(self, segment: Segment) -> list[tuple[Segment, Segment]]:
        """Every node of the hierarchy that is a proper part of a segment, and the rest, where it is large enough."""

        def found() -> list[tuple[Segment, Segment]]:
            parts = [(node, segment - node) for node in self.nodes if node < segment]
            return [(node, rest) for node, rest in parts if self.pixel_count(rest) >= MIN_SEGMENT_PX]

        return self.once(("nodes in", segment), found)

    def masks_in(self, segment: Segment) -> Mapping[Segment, Segment]:
        """Every mask of the pool that cuts a segment, with what is left of the segment without it."""
        return self.once(
            ("masks in", segment),
            lambda: {mask: segment - mask for mask in self.masks if not mask.isdisjoint(segment)},
        )

    def split(self, segment: Segment) -> tuple[Segment, Segment] | None:
        """The two parts that a segment falls into first; None where one would be too small."""

        def found() -> tuple[Segment, Segment] | None:
            parts = split(segment, self.search_input.atoms, self.hierarchy)
            large = parts is not None and min(map(self.pixel_count, parts)) >= MIN_SEGMENT_PX
            return parts if large else None

        return self.once(("split", segment), found)

    def once(self, key: Hashable, make: Callable[[], Made]) -> Made:
        """What is found out about a thing, such as a move's own parts of a segment; made when first asked for.

        Args:
            key: by whom, and about what.
        """
        if key not in self._made:
            self._made[key] = make()
        made: Made = self._made[key]
        return made

    @cached_property
    def nodes(self) -> tuple[Segment, ...]:
        """Every part of the hierarchy that is large enough for a segment, small ones first."""
        return tuple(s for s in nodes(self.hierarchy) if self.pixel_count(s) >= MIN_SEGMENT_PX)

    @cached_property
    def masks(self) -> tuple[Segment, ...]:
        """The pool: what was offered, and the nodes of the hierarchy; each once, and large enough."""
        pool = dict.fromkeys([*self.offered, *self.nodes])
        return tuple(mask for mask in pool if self.pixel_count(mask) >= MIN_SEGMENT_PX)

    @cached_property
    def touching(self) -> dict[int, set[int]]:
        """The neighbours of each atom."""
        return {atom: set(row) for atom, row in self.hierarchy.borders.items()}

    @cached_property
    def _atom_pixels(self) -> list[int]:
        return [int(n) for n in self.search_input.atoms.pixel_count]

    @cached_property
    def _pixels(self) -> dict[Segment, int]:
        return {}

    @cached_property
    def _losses(self) -> dict[Segment, float]:
        return {}

    @cached_property
    def _made(self) -> dict[Hashable, Any]:
        return {}


def problem_of(
    search_input: SearchInput,
    rules: Rules,
    potentials: Potentials,
    energy: EnergyFactory,
    pool: Pool | None = None,
    columns: Sequence[SegmentColumns] = (),
) -> Problem:
    """The problem of an image, alike for training and for parsing."""
    observation, atoms = search_input.observation, search_input.atoms
    hierarchy = build_hierarchy(atoms)
    build = SceneBuilder(observation.cloud, search_input.occlusion, observation.ground, atoms, rules)
    describe = Describer(observation, atoms, hierarchy, potentials.background, columns)
    told = replace(search_input, start=build.told(search_input.start))
    offered = tuple(dict.fromkeys((pool or NoMasks())(search_input)))
    return Problem(
        search_input, hierarchy, build, describe, energy(potentials, told), potentials.alone, offered
    )
