"""From segmentations to scenes: fit, relate, trim, re-fit (paper, sections 4 to 6)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import torch
from torch import Tensor

from blockstab.boxes.background import BackgroundRules, is_background
from blockstab.boxes.box import Boxes
from blockstab.boxes.catalogue import BoxFitter, Catalogue, SegmentPoints
from blockstab.boxes.fitting import MinimumSurface
from blockstab.rgbd.cloud import Cloud
from blockstab.rgbd.ground import Ground
from blockstab.scene import Pairs, Scene
from blockstab.segments.atoms import Atoms
from blockstab.segments.segmentation import Segment, Segmentation
from blockstab.stability.balance import Balance, balance
from blockstab.stability.refit import refit_axes
from blockstab.stability.support import Supports, SupportRules, candidate_supports
from blockstab.stability.trimming import trim

_UNION = 8  # scenes judged together: their boxes form one table, and its square is what costs


@dataclass(frozen=True)
class Rules:
    """How a segmentation is understood.

    Args:
        fitter: fits boxes to points.
        support: thresholds of section 5.2.
        background: what counts as table, floor or wall.
        trimming: drop the supports that stability does not need; without it every candidate counts (the
            paper's "Neighbor").
        refit_rounds: how often boxes follow the surface they stand on (the paper's Supp-surf); 0 is Min-surf.
    """

    fitter: BoxFitter = field(default_factory=MinimumSurface)
    support: SupportRules = SupportRules()
    background: BackgroundRules = BackgroundRules()
    trimming: bool = True
    refit_rounds: int = 2


@dataclass(frozen=True)
class _Union:
    """The segments of several scenes in one table, without any relation across scenes."""

    segments: list[Segment]
    start: list[int]  # (S + 1,) where the segments of each scene begin
    first: Tensor  # (P,) pairs within the scenes
    second: Tensor
    pair_start: list[int]
    neighbours: Tensor  # (P,) bool


class Interpreter:
    """Understands segmentations of one image; what it has worked out once, it does not work out again."""

    def __init__(
        self, cloud: Cloud, ground: Ground, atoms: Atoms, rules: Rules, known: Tensor | None = None
    ) -> None:
        """Prepare the points of all atoms.

        Args:
            cloud: in the world frame; every atom needs at least one valid pixel.
            known: (A,) int64, 1 for atoms of known background (table, floor, walls), 0 for atoms of known objects;
                segments that hold an atom of -1 are told apart by `rules.background`. All are -1 where None.
        """
        inside = cloud.valid & (atoms.label > 0)
        self._points = SegmentPoints(
            cloud.points[inside], atoms.label[inside] - 1, len(atoms), rules.fitter.max_points
        )
        if bool((self._points.count == 0).any()):
            raise ValueError(f"Atom {int((self._points.count == 0).nonzero()[0]) + 1} holds no pixel with depth.")
        self.atoms, self.ground, self.rules = atoms, ground, rules
        self.catalogue = Catalogue(self._points, rules.fitter)
        self._known = torch.full((len(atoms),), -1) if known is None else known
        lowest = cloud.points[inside][:, 1].quantile(0.01) if int(inside.sum()) < 2**24 else torch.tensor(0.0)
        self.ground_height = float(lowest) if ground.height is None else ground.height
        self._background: dict[Segment, tuple[bool, bool]] = {}

    def __call__(self, segmentations: Sequence[Segmentation]) -> list[Scene]:
        """Understand segmentations; their new boxes are fitted in one batch."""
        self.catalogue.rows(list(dict.fromkeys(s for one in segmentations for s in one.segments)))
        scenes: list[Scene] = []
        for begin in range(0, len(segmentations), _UNION):
            scenes += self._understand(segmentations[begin : begin + _UNION])
        return scenes

    def _understand(self, segmentations: Sequence[Segmentation]) -> list[Scene]:
        union = self._united(segmentations)
        background, is_ground = self._backgrounds(union.segments)
        rows = self.catalogue.rows(union.segments)
        axes = torch.full((len(rows), 3), float("nan"), dtype=torch.float64)
        for round_ in range(self.rules.refit_rounds + 1):
            boxes = self.catalogue.boxes(rows)
            candidates = self._candidates(union, rows, ~background, is_ground)
            supports = trim(boxes, candidates) if self.rules.trimming else candidates
            verdict = balance(boxes, ~background, supports)
            if round_ == self.rules.refit_rounds:
                break
            wanted = refit_axes(boxes, supports, verdict.stable & ~background)
            if torch.equal(wanted.nan_to_num(9.0), axes.nan_to_num(9.0)):
                break
            axes = wanted
            rows = self.catalogue.rows(union.segments, axes)
        return self._divided(segmentations, union, rows, background, candidates, supports, verdict)

    def _united(self, segmentations: Sequence[Segmentation]) -> _Union:
        start, pair_start, first, second, touching = [0], [0], [], [], []
        for one in segmentations:
            a, b = torch.triu_indices(len(one), len(one), offset=1)
            near = torch.zeros(len(one), len(one), dtype=torch.bool)
            left, right = one.neighbours(self.atoms)
            near[left, right] = near[right, left] = True
            touching.append(near[a, b])
            first.append(a + start[-1])
            second.append(b + start[-1])
            start.append(start[-1] + len(one))
            pair_start.append(pair_start[-1] + len(a))
        segments = [s for one in segmentations for s in one.segments]
        return _Union(segments, start, torch.cat(first), torch.cat(second), pair_start, torch.cat(touching))

    def _candidates(self, union: _Union, rows: Tensor, movable: Tensor, is_ground: Tensor) -> Supports:
        boxes = self.catalogue.boxes(rows)
        apart = self.catalogue.separation(rows[union.first], rows[union.second])
        height = torch.full((len(rows),), self.ground_height, dtype=torch.float64)
        pairs = union.first, union.second
        return candidate_supports(boxes, pairs, apart, height, movable, is_ground, self.rules.support)

    def _backgrounds(self, segments: list[Segment]) -> tuple[Tensor, Tensor]:
        """(N,) which segments are background, and (N,) which of those are the ground itself."""
        new = list(dict.fromkeys(s for s in segments if s not in self._background))
        if new:
            points, count, _ = self._points.gather(new)
            pixels = torch.tensor([sum(int(self.atoms.pixels[a]) for a in s) for s in new])
            share = pixels / self.atoms.label.numel()
            boxes = self.catalogue.boxes(self.catalogue.rows(new))
            found, level = is_background(boxes, points, count, share, self.ground_height, self.rules.background)
            least = torch.stack([self._known[list(s)].min() for s in new])
            found = torch.where(least >= 0, least > 0, found)
            self._background.update(zip(new, zip(found.tolist(), level.tolist(), strict=True), strict=True))
        found, level = torch.tensor([self._background[s] for s in segments]).view(-1, 2).unbind(dim=1)
        return found, found & level

    def _divided(
        self,
        segmentations: Sequence[Segmentation],
        union: _Union,
        rows: Tensor,
        background: Tensor,
        candidates: Supports,
        supports: Supports,
        verdict: Balance,
    ) -> list[Scene]:
        """One scene for each segmentation, out of the table of them all."""
        fits = self.catalogue.fits
        assert fits is not None  # every segmentation has segments, and they have been fitted
        boxes = self.catalogue.boxes(rows)
        apart = self.catalogue.separation(rows[union.first], rows[union.second])
        scenes = []
        for k, one in enumerate(segmentations):
            n, p = slice(union.start[k], union.start[k + 1]), slice(union.pair_start[k], union.pair_start[k + 1])
            pairs = Pairs(
                union.first[p] - n.start,
                union.second[p] - n.start,
                apart.gap[p],
                apart.direction[p],
                union.neighbours[p],
            )
            scenes.append(
                Scene(
                    segmentation=one,
                    ground=self.ground,
                    pixels=torch.stack([self.atoms.pixels[list(s)].sum() for s in one.segments]),
                    points=torch.stack([self._points.count[list(s)].sum() for s in one.segments]),
                    background=background[n],
                    boxes=Boxes(boxes.center[n], boxes.rotation[n], boxes.half_extent[n]),
                    fit_mean=fits.mean[rows[n]],
                    fit_variance=fits.variance[rows[n]],
                    visible_share=fits.visible_share[rows[n]],
                    pairs=pairs,
                    candidates=candidates.between(n.start, n.stop),
                    supports=supports.between(n.start, n.stop),
                    balance=verdict.between(n.start, n.stop),
                )
            )
        return scenes
