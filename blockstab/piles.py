"""Piles: groups of objects near enough to hold each other up. What a move changes, it changes within its piles."""

from __future__ import annotations

from dataclasses import dataclass

import torch
from torch import Tensor

from blockstab.boxes.box import Boxes
from blockstab.segments.segmentation import Segment
from blockstab.stability.balance import Balance
from blockstab.stability.support import GROUND, Supports

REACH_M = 0.05  # objects whose shadows on the ground are further apart than this do not interact

Pile = tuple[Segment, ...]


@dataclass(frozen=True)
class Judged:
    """Relations and verdicts over a table of boxes: all candidates, those that count, and which boxes stand."""

    candidates: Supports
    supports: Supports
    balance: Balance

    def between(self, start: int, stop: int) -> Judged:
        """The part about boxes `start` to `stop - 1`."""
        return Judged(
            self.candidates.between(start, stop),
            self.supports.between(start, stop),
            self.balance.between(start, stop),
        )


@dataclass(frozen=True)
class PileTable:
    """Several piles as one table of N segments, without any relation across them.

    Args:
        segments: N, pile after pile.
        start: where the segments of each pile begin, and N.
        first, second: (P,) every pair of segments within a pile.
    """

    segments: tuple[Segment, ...]
    start: tuple[int, ...]
    first: Tensor
    second: Tensor

    @staticmethod
    def of(piles: list[Pile]) -> PileTable:
        """The table of these piles; at least one."""
        start, first, second = [0], [], []
        for pile in piles:
            a, b = torch.triu_indices(len(pile), len(pile), offset=1)
            first.append(a + start[-1])
            second.append(b + start[-1])
            start.append(start[-1] + len(pile))
        segments = tuple(segment for pile in piles for segment in pile)
        return PileTable(segments, tuple(start), torch.cat(first), torch.cat(second))


def pile_numbers(boxes: Boxes, background: Tensor, touch: Tensor) -> Tensor:
    """Which objects form a pile: (N,) int64, the same number within one pile; -1 for background.

    Two objects belong together if the rectangles around their shadows on the ground, widened by `REACH_M` or by how
    close they must come to touch, `touch` (N,) metres, overlap; so do those that others link.
    """
    corners = boxes.corners()[..., [0, 2]]
    low, high = corners.amin(dim=1), corners.amax(dim=1)
    reach = touch.clamp(min=REACH_M)
    reach = torch.maximum(reach[:, None], reach)[..., None]
    near = ((low[:, None] - reach <= high) & (low <= high[:, None] + reach)).all(dim=-1)
    near &= ~background & ~background[:, None]
    number = torch.arange(len(boxes))
    while True:
        lowest = torch.where(near, number, len(boxes)).amin(dim=1)
        lowest = torch.where(background, -1, lowest)
        if torch.equal(lowest, number):
            return number
        number = lowest


def shifted(supports: Supports, index: Tensor) -> Supports:
    """The relations of a pile, its boxes renamed by `index` (n,)."""
    below = torch.where(supports.supporter == GROUND, GROUND, index[supports.supporter.clamp(min=0)])
    return Supports(below, index[supports.supported], supports.type, supports.area)
