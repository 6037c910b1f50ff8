"""The loop of sections 4 to 6: relate boxes, drop what stability does not need, correct what stands."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import torch
from torch import Tensor

from blockstab.boxes.background import BackgroundRules
from blockstab.boxes.box_cache import BoxCache, BoxFitter
from blockstab.boxes.fitting import MinimumSurface
from blockstab.rgbd.noise import DepthNoise
from blockstab.rgbd.occlusion import Occlusion
from blockstab.scene.islands import IslandTable, StabilityResult
from blockstab.stability.amodal import extended_down
from blockstab.stability.judges import StabilityJudge, TrimmedSupports
from blockstab.stability.refit import UP, refit_axes
from blockstab.stability.relating import related
from blockstab.stability.support import SupportRules


@dataclass(frozen=True)
class Rules:
    """Rules by which a segmentation is understood.

    Args:
        fitter: fits boxes to points.
        support: thresholds of section 5.2.
        background: what counts as table, floor or wall.
        judge: says what stands, and what carries it.
        refit_rounds: how often boxes are corrected by how they stand (the paper's Supp-surf); 0 is Min-surf.
    """

    fitter: BoxFitter = field(default_factory=MinimumSurface)
    support: SupportRules = field(default_factory=SupportRules)
    background: BackgroundRules = field(default_factory=BackgroundRules)
    judge: StabilityJudge = field(default_factory=TrimmedSupports)
    refit_rounds: int = 2

    def under(self, noise: DepthNoise) -> Rules:
        """The same rules for depth of this noise: what grows with the square of distance is stated for a Kinect."""
        times = noise.coarseness
        return replace(
            self,
            fitter=self.fitter.coarser(times),
            support=self.support.coarser(times),
            background=self.background.coarser(times),
        )


@dataclass(frozen=True)
class StabilityInference:
    """Reasons about islands of boxes.

    Args:
        box_cache: the boxes.
        occlusion: what was hidden from the camera.
        ground_height: metres.
        rules: the constants.
    """

    box_cache: BoxCache
    occlusion: Occlusion
    ground_height: float
    rules: Rules

    def __call__(
        self, table: IslandTable, background: Tensor, at_ground: Tensor
    ) -> tuple[Tensor, StabilityResult]:
        """Understand islands.

        Args:
            table: N segments; background: (N,) bool; at_ground: (N,) bool, lies in the ground plane.

        Returns:
            rows (N,) of their boxes in the cache, and what was found.
        """
        movable, is_ground = ~background, background & at_ground
        rows = self.box_cache.rows(table.segments)
        judged = self._judge(table, rows, movable, is_ground)
        refused = torch.zeros_like(movable)
        for _ in range(self.rules.refit_rounds):
            refitted = torch.where(refused, rows, self._refitted(table, rows, movable, judged))
            if torch.equal(refitted, rows):
                break
            standing = self._judge(table, refitted, movable, is_ground)
            # A box is corrected because it stands; one that would not stand afterwards stays as it was.
            fallen = (refitted != rows) & ~standing.balance.stable
            refused |= fallen
            rows = torch.where(fallen, rows, refitted)
            judged = self._judge(table, rows, movable, is_ground) if bool(fallen.any()) else standing
        if self.rules.refit_rounds:
            lengthened = self._lengthened(table, rows, movable, judged)
            if not torch.equal(lengthened, rows):
                rows, judged = lengthened, self._judge(table, lengthened, movable, is_ground)
        return rows, judged

    def _judge(self, table: IslandTable, rows: Tensor, movable: Tensor, is_ground: Tensor) -> StabilityResult:
        """Relate the boxes, and judge them."""
        boxes, support = self.box_cache.fits.boxes[rows], self.rules.support
        apart = self.box_cache.separation(rows[table.first], rows[table.second])
        pairs, height = (table.first, table.second), self._heights(len(rows))
        candidates = related(boxes, pairs, apart, height, movable, is_ground, support)
        return StabilityResult(
            candidates, *self.rules.judge(boxes, movable, candidates, support.noise(boxes))
        )

    def _refitted(self, table: IslandTable, rows: Tensor, movable: Tensor, judged: StabilityResult) -> Tensor:
        """Rows of the boxes after the re-fit (section 6): what stands on one surface follows that surface.

        What does not stand is fitted upright, if it fits as well so, as far as the sensor can tell: a bowl has
        no axes, noise decides those of its box, and of two equal guesses the one that stands is better.
        """
        fits, stable = self.box_cache.fits[rows], judged.balance.stable
        axes = refit_axes(fits.boxes, judged.supports, stable & movable)
        tried = movable & ~stable
        axes[tried] = UP
        chosen = (~axes.isnan().any(dim=1)).nonzero()[:, 0]
        result = rows.clone()
        result[chosen] = self.box_cache.rows([table.segments[i] for i in chosen.tolist()], axes[chosen])
        worse = self.box_cache.fits.mean[result] > fits.mean + self.rules.support.noise(fits.boxes)
        return torch.where(tried & worse, rows, result)

    def _lengthened(
        self, table: IslandTable, rows: Tensor, movable: Tensor, judged: StabilityResult
    ) -> Tensor:
        """Rows of the boxes after what has nothing beneath it was lengthened down, unseen."""
        floating = movable & (torch.bincount(judged.candidates.supported, minlength=len(rows)) == 0)
        if not bool(floating.any()):
            return rows
        longer = extended_down(
            self.box_cache.fits.boxes[rows],
            floating,
            (table.first, table.second),
            self._heights(len(rows)),
            lambda points: self.occlusion.hidden(points, self.rules.support.touch_m),
        )
        return self.box_cache.variants(rows, longer)

    def _heights(self, n: int) -> Tensor:
        return torch.full((n,), self.ground_height, dtype=torch.float64)
