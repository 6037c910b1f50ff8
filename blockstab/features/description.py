"""Scenes and their features: all that an energy sees of an image."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import torch
from torch import Tensor

from blockstab.features.appearance.pair_cache import Appearances
from blockstab.features.box_shape import box_shape
from blockstab.features.columns import SegmentColumns
from blockstab.features.contour import Contours
from blockstab.features.pairwise import neighbour_pairs, pairs_of, pairwise_features
from blockstab.features.surface import Surfaces
from blockstab.features.unary import unary_features
from blockstab.observation import Observation
from blockstab.scene.beside import beside
from blockstab.scene.types import Scene
from blockstab.segments.atoms import Atoms
from blockstab.segments.hierarchy import Hierarchy
from blockstab.segments.segmentation import Segment


@dataclass(frozen=True)
class Described:
    """A scene and its features.

    Args:
        scene: N segments, M boundaries between objects.
        unary: (N, F) float64, columns `SEGMENT_COLUMNS`, then those of one's own.
        pairwise: (M, 63) float64, columns `PAIRWISE_COLUMNS`, of the pairs of `neighbour_pairs(scene)`.
        lost: (N,) float64, the share of each segment's pixels that is expected to lie on things: what is lost if
            the segment is background.
    """

    scene: Scene
    unary: Tensor
    pairwise: Tensor
    lost: Tensor


class Describer:
    """Describes scenes of one image; each segment and each pair is looked at once."""

    def __init__(
        self,
        observation: Observation,
        atoms: Atoms,
        hierarchy: Hierarchy,
        background: Callable[[Tensor], Tensor],
        own: Sequence[SegmentColumns] = (),
    ) -> None:
        """Prepare the atoms.

        Args:
            background: from columns `LONE_COLUMNS` to the share of a segment that is expected to be things.
            own: columns beside ours.
        """
        self._own = own
        self._observation, self._atoms = observation, atoms
        self._contours = Contours(observation, atoms, hierarchy)
        self._surfaces = Surfaces(observation, atoms)
        self._appearances = Appearances(observation, atoms)
        self._rows = torch.empty(0, 0, dtype=torch.float64)
        self._row: dict[Segment, int] = {}
        self._background = background
        self._share: dict[Segment, float] = {}
        self._by_atoms: dict[Segment, float] = {}
        share = self._things([frozenset({atom}) for atom in range(len(atoms))])
        self._things_in = (share * atoms.pixel_count).tolist()

    def __call__(self, scenes: Sequence[Scene]) -> list[Described]:
        """Describe scenes; what is new of their segments and boundaries is looked at in one batch."""
        if not scenes:
            return []
        together, sizes = beside(scenes), list(map(len, scenes))
        segments = together.segmentation.segments
        own = [
            torch.cat([part(self._observation, self._atoms, s).double() for s in scenes])
            for part in self._own
        ]
        unary = torch.cat([unary_features(together), self._shape(together), self.lone(segments), *own], dim=1)
        pairs = [len(neighbour_pairs(scene)[0]) for scene in scenes]
        pairwise = pairwise_features(together, self._appearances(pairs_of(together)))
        parts = (torch.split(*it) for it in ((unary, sizes), (pairwise, pairs), (self.lost(together), sizes)))
        return list(map(Described, scenes, *parts))

    def lone(self, segments: Sequence[Segment]) -> Tensor:
        """Features of segments by themselves, (S, C) float64, columns `LONE_COLUMNS`."""
        new = list(dict.fromkeys(s for s in segments if s not in self._row))
        if new:
            rows = torch.cat([self._contours(new), self._surfaces(new)], dim=1)
            start = len(self._row)
            self._rows = torch.cat([self._rows.view(start, rows.shape[1]), rows])
            self._row.update(zip(new, range(start, start + len(new)), strict=True))
        return self._rows[torch.tensor([self._row[s] for s in segments], dtype=torch.int64)]

    def _shape(self, scene: Scene) -> Tensor:
        return box_shape(
            scene.boxes, scene.pixel_count, self._observation.frame.camera, self._observation.ground
        )

    def lost(self, scene: Scene) -> Tensor:
        """(N,) as in `Described`: the mean of what its atoms say one by one, and of what the whole says."""
        segments = scene.segmentation.segments
        by_atoms = [self._things_by_atoms(segment) for segment in segments]
        return (torch.tensor(by_atoms, dtype=torch.float64) / scene.pixel_count + self._things(segments)) / 2

    def _things_by_atoms(self, segment: Segment) -> float:
        """Pixels of things in a segment, as its atoms say one by one."""
        if segment not in self._by_atoms:
            # In one order, so that the sum is rounded alike however the segment came about.
            self._by_atoms[segment] = sum(self._things_in[atom] for atom in sorted(segment))
        return self._by_atoms[segment]

    def _things(self, segments: Sequence[Segment]) -> Tensor:
        """The share of things in each of S segments, judged as a whole, (S,); what is new is judged in one batch."""
        new = list(dict.fromkeys(s for s in segments if s not in self._share))
        if new:
            share = self._background(self.lone(new)).detach().clamp(0.0, 1.0)
            self._share.update(zip(new, share.tolist(), strict=True))
        return torch.tensor([self._share[s] for s in segments], dtype=torch.float64)
