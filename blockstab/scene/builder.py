"""From segmentations to scenes; only islands that no earlier segmentation had are thought over."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import NamedTuple

import torch
from torch import Tensor

from blockstab.boxes.background import is_background
from blockstab.boxes.box_cache import BoxCache, SegmentPoints
from blockstab.boxes.extent import surface_distance
from blockstab.boxes.separation import Separation
from blockstab.boxes.strays import without_strays
from blockstab.rgbd.cloud import Cloud
from blockstab.rgbd.ground import Ground
from blockstab.rgbd.occlusion import Occlusion
from blockstab.scene.inference import Rules, StabilityInference
from blockstab.scene.islands import Island, IslandTable, StabilityResult, island_numbers, joined, overlaid
from blockstab.scene.types import Pairs, Scene
from blockstab.segments.atoms import Atoms
from blockstab.segments.segmentation import Segment, Segmentation
from blockstab.stability.balance import Balance
from blockstab.stability.situation import Situation, Unseen

_TABLE = 1024  # segments judged together: the square of their number is what costs
_NO_GROUND_SHARE = 0.01  # of the points lie below the ground that is assumed where none was found


class _Found(NamedTuple):
    """Rows (n,) of the boxes of one island, and the verdicts."""

    rows: Tensor
    judged: StabilityResult


class AtomsInBox(NamedTuple):
    """Places of A atoms in a box, as far as their points tell.

    Args:
        atoms: their numbers, ascending.
        far: (A,) mean distance of their points to the nearest face, metres.
        step: (A,) one step of the depth sensor there, metres.
        middle, spread: (A, 3) mean and standard deviation along the axes of the box, from its centre, metres.
        half: (3,) half extent of the box.
    """

    atoms: list[int]
    far: Tensor
    step: Tensor
    middle: Tensor
    spread: Tensor
    half: Tensor


class SceneBuilder:
    """Understands segmentations of one image; what it has worked out once, it does not work out again."""

    def __init__(
        self,
        cloud: Cloud,
        occlusion: Occlusion,
        ground: Ground,
        atoms: Atoms,
        rules: Rules,
    ) -> None:
        """Prepare the points of all atoms.

        Args:
            cloud: in the world frame; every atom needs at least one valid pixel.
            occlusion: what was hidden from the camera.
            rules: among them, what tells background from objects where a segmentation says nothing.
        """
        rules = rules.under(cloud.noise)
        self._noise = cloud.noise
        inside = cloud.valid & (atoms.label > 0)
        points = cloud.points[inside]
        self._points = SegmentPoints(points, atoms.label[inside] - 1, len(atoms), rules.fitter.max_points)
        if bool((self._points.count == 0).any()):
            raise ValueError(
                f"Atom {int((self._points.count == 0).nonzero()[0]) + 1} holds no pixel with depth."
            )
        self.atoms, self.ground, self.rules, self.occlusion = atoms, ground, rules, occlusion
        self.box_cache = BoxCache(self._points, rules.fitter)
        height = _lowest(points) if ground.height is None else ground.height
        self._reason = StabilityInference(self.box_cache, occlusion, height, rules)
        self._background: dict[Segment, tuple[bool, bool]] = {}
        self._told: dict[Segmentation, tuple[Tensor, Tensor]] = {}
        self._found: dict[Island, _Found] = {}
        self._in_box: dict[Segment, AtomsInBox] = {}
        self._sizes: dict[Segment, tuple[int, int]] = {}

    def __call__(self, segmentations: Sequence[Segmentation]) -> list[Scene]:
        """Understand segmentations; their new boxes are fitted in one batch, their new islands judged in one."""
        segments = list(dict.fromkeys(s for one in segmentations for s in one.segments))
        self.box_cache.rows(segments)
        self._by_rules(segments)
        islands = [self._islands(one) for one in segmentations]
        self._think(list(dict.fromkeys(p for some in islands for p in some if p not in self._found)))
        rows = [self._rows(one, some) for one, some in zip(segmentations, islands, strict=True)]
        pairs = [torch.triu_indices(len(one), len(one), offset=1) for one in rows]
        apart = self._apart(rows, pairs)
        return list(map(self._scene, segmentations, islands, rows, pairs, apart))

    def told(self, one: Segmentation) -> Segmentation:
        """The same segmentation, told of every segment whether it is background."""
        self.box_cache.rows(list(one.segments))
        found, _ = self._backgrounds(one)
        return one.telling(dict(zip(one.segments, found.tolist(), strict=True)))

    def as_seen(self, scene: Scene) -> Situation:
        """The boxes of a scene as far as they were seen: without what was added to them, and without strays."""
        one = scene.segmentation
        rows = self.box_cache.fitted(self._rows(one, self._islands(one)))
        points, count, _ = self._points.gather(list(one.segments))
        return Situation(
            without_strays(self.box_cache.fits.boxes[rows], points, count),
            ~scene.background,
            scene.background & self._backgrounds(one)[1],
            self._reason.ground_height,
            self.rules.support,
            self.rules.judge,
            Unseen.none(),
        )

    def in_box(self, segment: Segment) -> AtomsInBox:
        """Places of the atoms of a segment in the box that is fitted to it by itself."""
        if segment not in self._in_box:
            atoms = sorted(segment)
            box = self.box_cache.fits.boxes[self.box_cache.rows([segment])]
            points, count, _ = self._points.gather([frozenset({atom}) for atom in atoms])
            present = torch.arange(points.shape[1]) < count[:, None]
            local = box.local(points.view(1, -1, 3)).view(points.shape)
            total = count.double()
            far = surface_distance(local, box.half_extent[:, None]) * present
            step = self._noise.at(points.square().sum(dim=-1)) * present
            middle = (local * present[..., None]).sum(dim=1) / total[:, None]
            spread = ((local - middle[:, None]) * present[..., None]).square().sum(dim=1) / total[:, None]
            self._in_box[segment] = AtomsInBox(
                atoms,
                far.sum(dim=1) / total,
                step.sum(dim=1) / total,
                middle,
                spread.sqrt(),
                box.half_extent[0],
            )
        return self._in_box[segment]

    def _islands(self, segmentation: Segmentation) -> list[Island]:
        """The islands of a segmentation; background that is not the ground belongs to each, as a support."""
        segments = segmentation.segments
        background, at_ground = self._backgrounds(segmentation)
        rows = self.box_cache.rows(segments)
        boxes = self.box_cache.fits.boxes[rows]
        number = island_numbers(boxes, background, self.rules.support.touch(boxes)).tolist()
        walls = [
            s
            for s, b, g in zip(segments, background.tolist(), at_ground.tolist(), strict=True)
            if b and not g
        ]
        members: dict[int, list[Segment]] = {}
        for segment, island in zip(segments, number, strict=True):
            if island >= 0:
                members.setdefault(island, []).append(segment)
        return [Island(tuple(objects), tuple(walls)) for objects in members.values()]

    def _think(self, islands: list[Island]) -> None:
        """Reason about islands, as many at a time as make a table of a good size."""
        while islands:
            size, amount = 0, 0
            while amount < len(islands) and (not amount or size + len(islands[amount].segments) <= _TABLE):
                size, amount = size + len(islands[amount].segments), amount + 1
            table = IslandTable.of(islands[:amount])
            rows, judged = self._reason(table, ~table.movable, self._by_rules(table.segments)[1])
            parts = zip(islands, pairwise(table.start), judged.split(table.start), strict=False)
            self._found.update((island, _Found(rows[slice(*ends)], part)) for island, ends, part in parts)
            islands = islands[amount:]

    def _rows(self, one: Segmentation, islands: list[Island]) -> Tensor:
        """(N,) rows of the boxes of a segmentation, as they were corrected in its islands."""
        row = dict(zip(one.segments, self.box_cache.rows(one.segments).tolist(), strict=True))
        for island in islands:
            row.update(zip(island.segments, self._found[island].rows.tolist(), strict=True))
        return torch.tensor([row[segment] for segment in one.segments], dtype=torch.long)

    def _apart(self, rows: list[Tensor], pairs: list[Tensor]) -> list[Separation]:
        """Gaps and directions of the pairs of each segmentation, what is new of them in one batch."""
        if not rows:
            return []
        ends = torch.cat([row[pair] for row, pair in zip(rows, pairs, strict=True)], dim=1)
        apart, sizes = self.box_cache.separation(*ends), [pair.shape[1] for pair in pairs]
        return [
            Separation(*part) for part in zip(*(torch.split(column, sizes) for column in apart), strict=True)
        ]

    def _scene(
        self, one: Segmentation, islands: list[Island], rows: Tensor, pairs: Tensor, apart: Separation
    ) -> Scene:
        """Put the islands of a segmentation together."""
        place = {segment: i for i, segment in enumerate(one.segments)}
        names = [[place[segment] for segment in island.segments] for island in islands]
        found = [self._found[island].judged for island in islands]
        fits, (first, second) = self.box_cache.fits[rows], pairs
        pixels, points = torch.tensor([self._size(s) for s in one.segments]).view(-1, 2).unbind(dim=1)
        return Scene(
            segmentation=one,
            ground=self.ground,
            pixel_count=pixels,
            point_count=points,
            background=self._backgrounds(one)[0],
            boxes=fits.boxes,
            fit_mean=fits.mean,
            fit_variance=fits.variance,
            visible_share=fits.visible_share,
            pairs=Pairs(
                first, second, apart.gap, apart.direction, _bordering(one, self.atoms, first, second)
            ),
            candidates=joined([part.candidates for part in found], names),
            supports=joined([part.supports for part in found], names),
            balance=overlaid(
                Balance.of_background(fits.boxes.center), [part.balance for part in found], names
            ),
        )

    def _size(self, segment: Segment) -> tuple[int, int]:
        """Pixel count and point count of a segment."""
        if segment not in self._sizes:
            atoms = list(segment)
            self._sizes[segment] = (
                int(self.atoms.pixel_count[atoms].sum()),
                int(self._points.count[atoms].sum()),
            )
        return self._sizes[segment]

    def _backgrounds(self, one: Segmentation) -> tuple[Tensor, Tensor]:
        """(N,) which segments are background, as told or by the rules, and (N,) which lie in the ground plane."""
        if one not in self._told:
            found, level = self._by_rules(one.segments)
            told = [
                one.background.get(s, by_rules)
                for s, by_rules in zip(one.segments, found.tolist(), strict=True)
            ]
            self._told[one] = torch.tensor(told, dtype=torch.bool), level
        return self._told[one]

    def _by_rules(self, segments: Sequence[Segment]) -> tuple[Tensor, Tensor]:
        """The same, where nothing is told."""
        new = list(dict.fromkeys(s for s in segments if s not in self._background))
        if new:
            points, count, _ = self._points.gather(new)
            pixels = torch.tensor([self._size(s)[0] for s in new])
            boxes = self.box_cache.fits.boxes[self.box_cache.rows(new)]
            share = pixels / self.atoms.label.numel()
            height = self._reason.ground_height
            found, level = is_background(boxes, points, count, share, height, self.rules.background)
            self._background.update(zip(new, zip(found.tolist(), level.tolist(), strict=True), strict=True))
        found, level = torch.tensor([self._background[s] for s in segments]).view(-1, 2).unbind(dim=1)
        return found, level


def _bordering(one: Segmentation, atoms: Atoms, first: Tensor, second: Tensor) -> Tensor:
    """(P,) bool, whether the two segments of each pair share a border in the image."""
    near = torch.zeros(len(one), len(one), dtype=torch.bool)
    left, right = one.neighbours(atoms)
    near[left, right] = near[right, left] = True
    return near[first, second]


def _lowest(points: Tensor) -> float:
    rank = int(_NO_GROUND_SHARE * len(points)) + 1
    return float(points[:, 1].kthvalue(rank).values)
