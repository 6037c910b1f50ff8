"""Scenes and their features: all that an energy sees of an image."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import chain

import torch
from torch import Tensor

from blockstab.boxes.box import concatenate
from blockstab.features.appearance.pair_cache import Appearances
from blockstab.features.box_shape import box_shape
from blockstab.features.columns import SegmentColumns
from blockstab.features.contour import Contours
from blockstab.features.pairwise import pairs_of, pairwise_features
from blockstab.features.surface import Surfaces
from blockstab.features.unary import unary_features
from blockstab.observation import Observation
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
        segments, sizes = [s for scene in scenes for s in scene.segmentation.segments], list(map(len, scenes))
        lone = torch.split(self.lone(segments), sizes)
        shape = torch.split(self._shape(scenes), sizes)
        self._things(segments)
        pairs = [pairs_of(scene) for scene in scenes]
        looks = torch.split(self._appearances(list(chain(*pairs))), [len(some) for some in pairs])
        return [
            Described(scene, self._unary(scene, *rows), pairwise_features(scene, look), self.lost(scene))
            for scene, look, *rows in zip(scenes, looks, shape, lone, strict=True)
        ]

    def lone(self, segments: Sequence[Segment]) -> Tensor:
        """Features of segments by themselves, (S, C) float64, columns `LONE_COLUMNS`."""
        new = list(dict.fromkeys(s for s in segments if s not in self._row))
        if new:
            rows = torch.cat([self._contours(new), self._surfaces(new)], dim=1)
            start = len(self._row)
            self._rows = torch.cat([self._rows.view(start, rows.shape[1]), rows])
            self._row.update(zip(new, range(start, start + len(new)), strict=True))
        return self._rows[torch.tensor([self._row[s] for s in segments], dtype=torch.int64)]

    def _shape(self, scenes: Sequence[Scene]) -> Tensor:
        """`box_shape` of all their boxes, one after the other."""
        boxes, pixels = concatenate([one.boxes for one in scenes]), torch.cat([s.pixel_count for s in scenes])
        return box_shape(boxes, pixels, self._observation.frame.camera, self._observation.ground)

    def _unary(self, scene: Scene, shape: Tensor, lone: Tensor) -> Tensor:
        own = [part(self._observation, self._atoms, scene).double() for part in self._own]
        return torch.cat([unary_features(scene), shape, lone, *own], dim=1)

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
