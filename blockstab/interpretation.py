"""From segmentations to scenes; only piles that no earlier segmentation had are thought over."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import torch
from torch import Tensor

from blockstab.boxes.background import is_background
from blockstab.boxes.catalogue import Catalogue, SegmentPoints
from blockstab.piles import Judged, Pile, PileTable, pile_numbers, shifted
from blockstab.reasoning import Reasoning, Rules
from blockstab.rgbd.cloud import Cloud
from blockstab.rgbd.ground import Ground
from blockstab.rgbd.sight import Sight
from blockstab.scene import Pairs, Scene
from blockstab.segments.atoms import Atoms
from blockstab.segments.segmentation import Segment, Segmentation
from blockstab.stability.balance import Balance
from blockstab.stability.support import join

_TABLE = 1024  # segments judged together: the square of their number is what costs
_NO_GROUND_SHARE = 0.01  # of the points lie below the ground that is assumed where none was found


class _Found(NamedTuple):
    """What is known of one pile: rows (n,) of its boxes, and the verdicts."""

    rows: Tensor
    judged: Judged


class Interpreter:
    """Understands segmentations of one image; what it has worked out once, it does not work out again."""

    def __init__(
        self,
        cloud: Cloud,
        sight: Sight,
        ground: Ground,
        atoms: Atoms,
        rules: Rules,
        known: Tensor | None = None,
    ) -> None:
        """Prepare the points of all atoms.

        Args:
            cloud: in the world frame; every atom needs at least one valid pixel.
            sight: what was hidden from the camera.
            known: (A,) int64, 1 for atoms of known background (table, floor, walls), 0 for atoms of known objects;
                segments that hold an atom of -1 are told apart by `rules.background`. All are -1 where None.
        """
        inside = cloud.valid & (atoms.label > 0)
        points = cloud.points[inside]
        self._points = SegmentPoints(points, atoms.label[inside] - 1, len(atoms), rules.fitter.max_points)
        if bool((self._points.count == 0).any()):
            raise ValueError(
                f"Atom {int((self._points.count == 0).nonzero()[0]) + 1} holds no pixel with depth."
            )
        self.atoms, self.ground, self.rules = atoms, ground, rules
        self.catalogue = Catalogue(self._points, rules.fitter)
        height = _lowest(points) if ground.height is None else ground.height
        self._reason = Reasoning(self.catalogue, sight, height, rules)
        self._known = torch.full((len(atoms),), -1) if known is None else known
        self._background: dict[Segment, tuple[bool, bool]] = {}
        self._found: dict[Pile, _Found] = {}

    def __call__(self, segmentations: Sequence[Segmentation]) -> list[Scene]:
        """Understand segmentations; their new boxes are fitted in one batch, their new piles judged in one."""
        self.catalogue.rows(list(dict.fromkeys(s for one in segmentations for s in one.segments)))
        piles = [self._piles(one) for one in segmentations]
        self._think(list(dict.fromkeys(p for some in piles for p in some if p not in self._found)))
        return [self._scene(one, some) for one, some in zip(segmentations, piles, strict=True)]

    def _piles(self, segmentation: Segmentation) -> list[Pile]:
        """The piles of a segmentation; background that is not the ground belongs to each, as a support."""
        segments = segmentation.segments
        background, at_ground = self._backgrounds(segments)
        rows = self.catalogue.rows(segments)
        boxes = self.catalogue.fits.boxes[rows]
        number = pile_numbers(boxes, background, self.rules.support.touch(boxes)).tolist()
        walls = [
            s
            for s, b, g in zip(segments, background.tolist(), at_ground.tolist(), strict=True)
            if b and not g
        ]
        members: dict[int, list[Segment]] = {}
        for segment, pile in zip(segments, number, strict=True):
            if pile >= 0:
                members.setdefault(pile, []).append(segment)
        return [(*objects, *walls) for objects in members.values()]

    def _think(self, piles: list[Pile]) -> None:
        """Reason about piles, as many at a time as make a table of a good size."""
        while piles:
            size, amount = 0, 0
            while amount < len(piles) and (not amount or size + len(piles[amount]) <= _TABLE):
                size, amount = size + len(piles[amount]), amount + 1
            table = PileTable.of(piles[:amount])
            rows, judged = self._reason(table, *self._backgrounds(table.segments))
            for pile, start, stop in zip(piles, table.start[:-1], table.start[1:], strict=False):
                self._found[pile] = _Found(rows[start:stop], judged.between(start, stop))
            piles = piles[amount:]

    def _scene(self, one: Segmentation, piles: list[Pile]) -> Scene:
        """Put the piles of a segmentation together."""
        place = {segment: i for i, segment in enumerate(one.segments)}
        n = len(one)
        rows = self.catalogue.rows(one.segments)
        verdict = Balance.of_background(self.catalogue.fits.boxes.center[rows])
        candidates, supports = [], []
        for pile in piles:
            found = self._found[pile]
            index = torch.tensor([place[segment] for segment in pile])
            rows[index] = found.rows
            verdict = verdict.with_rows(index, found.judged.balance)
            candidates.append(shifted(found.judged.candidates, index))
            supports.append(shifted(found.judged.supports, index))
        fits = self.catalogue.fits[rows]
        first, second = torch.triu_indices(n, n, offset=1)
        apart = self.catalogue.separation(rows[first], rows[second])
        return Scene(
            segmentation=one,
            ground=self.ground,
            pixels=torch.stack([self.atoms.pixels[list(s)].sum() for s in one.segments]),
            points=torch.stack([self._points.count[list(s)].sum() for s in one.segments]),
            background=self._backgrounds(one.segments)[0],
            boxes=fits.boxes,
            fit_mean=fits.mean,
            fit_variance=fits.variance,
            visible_share=fits.visible_share,
            pairs=Pairs(
                first, second, apart.gap, apart.direction, _bordering(one, self.atoms, first, second)
            ),
            candidates=join(candidates),
            supports=join(supports),
            balance=verdict,
        )

    def _backgrounds(self, segments: Sequence[Segment]) -> tuple[Tensor, Tensor]:
        """(N,) which segments are background, and (N,) which lie in the ground plane."""
        new = list(dict.fromkeys(s for s in segments if s not in self._background))
        if new:
            points, count, _ = self._points.gather(new)
            pixels = torch.stack([self.atoms.pixels[list(s)].sum() for s in new])
            boxes = self.catalogue.fits.boxes[self.catalogue.rows(new)]
            share = pixels / self.atoms.label.numel()
            height = self._reason.ground_height
            found, level = is_background(boxes, points, count, share, height, self.rules.background)
            least = torch.stack([self._known[list(s)].min() for s in new])
            found = torch.where(least >= 0, least > 0, found)
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
