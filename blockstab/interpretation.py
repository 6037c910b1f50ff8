"""From segmentations to scenes: fit, relate, trim, re-fit (paper, sections 4 to 6)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import torch
from torch import Tensor

from blockstab.boxes.background import BackgroundRules, is_background
from blockstab.boxes.catalogue import BoxFitter, Catalogue, SegmentPoints
from blockstab.boxes.fitting import MinimumSurface
from blockstab.rgbd.cloud import Cloud
from blockstab.rgbd.ground import Ground
from blockstab.rgbd.sight import Sight
from blockstab.scene import Scene
from blockstab.segments.atoms import Atoms
from blockstab.segments.segmentation import Segment, Segmentation
from blockstab.stability.balance import balance
from blockstab.stability.reach import reach_down
from blockstab.stability.refit import UP, refit_axes
from blockstab.stability.support import SupportRules, candidate_supports
from blockstab.stability.trimming import trim
from blockstab.union import Judged, Union

_UNION = 8  # scenes judged together: their boxes form one table, and its square is what costs
_NO_GROUND_SHARE = 0.01  # of the points lie below the ground that is assumed where none was found


@dataclass(frozen=True)
class Rules:
    """How a segmentation is understood.

    Args:
        fitter: fits boxes to points.
        support: thresholds of section 5.2.
        background: what counts as table, floor or wall.
        trimming: drop the supports that stability does not need; without it every candidate counts (the
            paper's "Neighbor").
        refit_rounds: how often boxes are corrected by how they stand (the paper's Supp-surf); 0 is Min-surf.
    """

    fitter: BoxFitter = field(default_factory=MinimumSurface)
    support: SupportRules = SupportRules()
    background: BackgroundRules = BackgroundRules()
    trimming: bool = True
    refit_rounds: int = 2


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
        self._points = SegmentPoints(
            points, atoms.label[inside] - 1, len(atoms), rules.fitter.max_points
        )
        if bool((self._points.count == 0).any()):
            raise ValueError(f"Atom {int((self._points.count == 0).nonzero()[0]) + 1} holds no pixel with depth.")
        self.atoms, self.sight, self.ground, self.rules = atoms, sight, ground, rules
        self.catalogue = Catalogue(self._points, rules.fitter)
        self._known = torch.full((len(atoms),), -1) if known is None else known
        self._ground_height = _lowest(points) if ground.height is None else ground.height
        self._background: dict[Segment, tuple[bool, bool]] = {}

    def __call__(self, segmentations: Sequence[Segmentation]) -> list[Scene]:
        """Understand segmentations; their new boxes are fitted in one batch."""
        self.catalogue.rows(list(dict.fromkeys(s for one in segmentations for s in one.segments)))
        scenes: list[Scene] = []
        for begin in range(0, len(segmentations), _UNION):
            scenes += self._understand(Union.of(segmentations[begin : begin + _UNION], self.atoms))
        return scenes

    def _understand(self, union: Union) -> list[Scene]:
        background, at_ground = self._backgrounds(union.segments)
        movable, is_ground = ~background, background & at_ground
        rows = self.catalogue.rows(union.segments)
        judged = self._judged(union, rows, movable, is_ground)
        for _ in range(self.rules.refit_rounds):
            refitted = self._refitted(union, rows, movable, judged)
            if torch.equal(refitted, rows):
                break
            standing = self._judged(union, refitted, movable, is_ground)
            # A box is corrected because it stands; one that would not stand afterwards stays as it was.
            fallen = (refitted != rows) & ~standing.balance.stable
            rows = torch.where(fallen, rows, refitted)
            judged = self._judged(union, rows, movable, is_ground) if bool(fallen.any()) else standing
        if self.rules.refit_rounds:
            lengthened = self._lengthened(union, rows, movable, judged)
            if not torch.equal(lengthened, rows):
                rows, judged = lengthened, self._judged(union, lengthened, movable, is_ground)
        return union.divided(
            self.ground,
            torch.stack([self.atoms.pixels[list(s)].sum() for s in union.segments]),
            torch.stack([self._points.count[list(s)].sum() for s in union.segments]),
            background,
            self.catalogue.fits[rows],
            self.catalogue.separation(rows[union.first], rows[union.second]),
            judged,
        )

    def _judged(self, union: Union, rows: Tensor, movable: Tensor, is_ground: Tensor) -> Judged:
        """Relate the boxes, drop what stability does not need, and judge them."""
        boxes, support = self.catalogue.fits[rows].boxes, self.rules.support
        apart = self.catalogue.separation(rows[union.first], rows[union.second])
        pairs, height = (union.first, union.second), self._heights(len(rows))
        candidates = candidate_supports(boxes, pairs, apart, height, movable, is_ground, support)
        slack = support.noise(boxes)
        supports = trim(boxes, candidates, slack) if self.rules.trimming else candidates
        return Judged(candidates, supports, balance(boxes, movable, supports, slack))

    def _refitted(self, union: Union, rows: Tensor, movable: Tensor, judged: Judged) -> Tensor:
        """Rows of the boxes after the re-fit (section 6): what stands on one surface follows that surface.

        What does not stand is fitted upright, if it fits as well so, as far as the sensor can tell: a bowl has
        no axes, noise decides those of its box, and of two equal guesses the one that stands is better.
        """
        fits, stable = self.catalogue.fits[rows], judged.balance.stable
        axes = refit_axes(fits.boxes, judged.supports, stable & movable)
        follows = ~axes.isnan().any(dim=1)
        unstable = (movable & ~stable).nonzero()[:, 0]
        axes[unstable] = UP
        tried = torch.zeros_like(follows)
        tried[unstable] = True
        chosen = (follows | tried).nonzero()[:, 0]
        result = rows.clone()
        result[chosen] = self.catalogue.rows([union.segments[i] for i in chosen.tolist()], axes[chosen])
        worse = self.catalogue.fits[result].mean > fits.mean + self.rules.support.noise(fits.boxes)
        return torch.where(tried & worse, rows, result)

    def _lengthened(self, union: Union, rows: Tensor, movable: Tensor, judged: Judged) -> Tensor:
        """Rows of the boxes after what has nothing beneath it was lengthened down, unseen."""
        floating = movable & (torch.bincount(judged.candidates.supported, minlength=len(rows)) == 0)
        if not bool(floating.any()):
            return rows
        boxes, slack = self.catalogue.fits[rows].boxes, self.rules.support.touch_m
        longer = reach_down(
            boxes,
            floating,
            (union.first, union.second),
            self._heights(len(rows)),
            lambda points: self.sight.hidden(points, slack),
        )
        return self.catalogue.variants(rows, longer)

    def _heights(self, n: int) -> Tensor:
        return torch.full((n,), self._ground_height, dtype=torch.float64)

    def _backgrounds(self, segments: Sequence[Segment]) -> tuple[Tensor, Tensor]:
        """(N,) which segments are background, and (N,) which lie in the ground plane."""
        new = list(dict.fromkeys(s for s in segments if s not in self._background))
        if new:
            points, count, _ = self._points.gather(new)
            pixels = torch.stack([self.atoms.pixels[list(s)].sum() for s in new])
            boxes = self.catalogue.fits[self.catalogue.rows(new)].boxes
            share = pixels / self.atoms.label.numel()
            found, level = is_background(boxes, points, count, share, self._ground_height, self.rules.background)
            least = torch.stack([self._known[list(s)].min() for s in new])
            found = torch.where(least >= 0, least > 0, found)
            self._background.update(zip(new, zip(found.tolist(), level.tolist(), strict=True), strict=True))
        found, level = torch.tensor([self._background[s] for s in segments]).view(-1, 2).unbind(dim=1)
        return found, level


def _lowest(points: Tensor) -> float:
    rank = int(_NO_GROUND_SHARE * len(points)) + 1
    return float(points[:, 1].kthvalue(rank).values)
