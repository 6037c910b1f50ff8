"""Situation of boxes: all that says what may carry what, so that it can be asked again with other boxes in place."""

from __future__ import annotations

from dataclasses import dataclass

import torch
from torch import Tensor

from blockstab.boxes.box import Boxes
from blockstab.geometry.convex_hulls import Polygons
from blockstab.stability.judges import TOGETHER, StabilityJudge, Verdicts
from blockstab.stability.relating import related_on
from blockstab.stability.support import GROUND, SupportRules, Supports, SupportType, join
from blockstab.stability.unseen import grown


@dataclass(frozen=True)
class Unseen:
    """Areas on which something that was not seen carries boxes.

    Args:
        supported: (H,) int64 box indices.
        area: H areas on the ground plane, in (x, z) metres.
    """

    supported: Tensor
    area: Polygons

    @staticmethod
    def none() -> Unseen:
        """No area."""
        empty = torch.empty(0, dtype=torch.int64)
        return Unseen(empty, Polygons(torch.empty(0, 1, 2, dtype=torch.float64), empty))

    def supports(self) -> Supports:
        """The same as relations; what carries is nothing that has a name, so the ground stands for it."""
        on = torch.full_like(self.supported, GROUND)
        return Supports(on, self.supported, torch.full_like(on, int(SupportType.SURFACE)), self.area)


@dataclass(frozen=True)
class Situation:
    """N boxes in the world frame, and what they may stand on.

    Args:
        boxes: where they are.
        movable: (N,) bool, the others are background.
        is_ground: (N,) bool, background that is the ground plane itself.
        ground_height: y of the ground, metres.
        rules: how near boxes touch.
        judge: says which of them stand.
        unseen: what is carried by something that nobody saw.
    """

    boxes: Boxes
    movable: Tensor
    is_ground: Tensor
    ground_height: float
    rules: SupportRules
    judge: StabilityJudge
    unseen: Unseen

    def candidates(self) -> Supports:
        """All relations that nearness allows, and what carries unseen."""
        return self._candidates(self.boxes, 1)

    def verdicts(self, candidates: Supports | None = None) -> Verdicts:
        """What the judge says."""
        known = self.candidates() if candidates is None else candidates
        return self.judge(self.boxes, self.movable, known, self.rules.noise(self.boxes))

    def standing_with(self, added: Tensor) -> Tensor:
        """Which boxes stand, (K, N) bool, where in each of K copies the faces go on by `added` (K, N, 6) metres."""
        together = max(1, TOGETHER // max(len(self.boxes), 1))
        parts = [self._together(some) for some in torch.split(added, together)]
        return torch.cat(parts) if parts else torch.empty(0, len(self.boxes), dtype=torch.bool)

    def _together(self, added: Tensor) -> Tensor:
        """The same, as one scene with copies of all boxes."""
        k, n = added.shape[:2]
        boxes = grown(self.boxes[torch.arange(n).repeat(k)], added.flatten(0, 1))
        near, movable = self._candidates(boxes, k), self.movable.repeat(k)
        return self.judge(boxes, movable, near, self.rules.noise(boxes)).balance.stable.view(k, n)

    def _candidates(self, boxes: Boxes, copies: int) -> Supports:
        """The candidates of so many copies of the boxes, one after the other."""
        n = len(self.boxes)
        first, second = torch.triu_indices(n, n, offset=1)
        shift = (torch.arange(copies) * n)[:, None]
        pairs = (first + shift).flatten(), (second + shift).flatten()
        movable, is_ground = self.movable.repeat(copies), self.is_ground.repeat(copies)
        near = related_on(self.ground_height, boxes, pairs, movable, is_ground, self.rules)
        if not len(self.unseen.supported):
            return near
        some = self.unseen.supports()
        again = torch.arange(len(some)).repeat(copies)
        above = (some.supported + shift).flatten()
        return join([near, Supports(some.supporter[again], above, some.type[again], some.area[again])])

    def part(self, members: Tensor) -> Situation:
        """The situation of some boxes (M,) alone."""
        place = torch.full((len(self.boxes),), -1)
        place[members] = torch.arange(len(members))
        kept = place[self.unseen.supported] >= 0
        unseen = Unseen(place[self.unseen.supported[kept]], self.unseen.area[kept])
        return Situation(
            self.boxes[members],
            self.movable[members],
            self.is_ground[members],
            self.ground_height,
            self.rules,
            self.judge,
            unseen,
        )
