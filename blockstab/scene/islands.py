"""Islands of objects near enough to hold each other up. What a move changes, it changes within its islands."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import accumulate, chain, pairwise
from typing import NamedTuple

import torch
from torch import Tensor

from blockstab.boxes.box import Boxes
from blockstab.segments.segmentation import Segment
from blockstab.stability.balance import Balance, concatenate
from blockstab.stability.support import GROUND, Supports, join

INTERACTION_M = 0.05  # objects whose shadows on the ground are further apart than this do not interact


class Island(NamedTuple):
    """Objects that may hold each other up, and the background beside the ground, which may hold any of them."""

    objects: tuple[Segment, ...]
    walls: tuple[Segment, ...]

    @property
    def segments(self) -> tuple[Segment, ...]:
        """All of them, objects first."""
        return self.objects + self.walls


@dataclass(frozen=True)
class StabilityResult:
    """Relations and verdicts over a table of boxes: all candidates, those that count, and which boxes stand."""

    candidates: Supports
    supports: Supports
    balance: Balance

    def split(self, start: Sequence[int]) -> list[StabilityResult]:
        """The parts about the boxes `start[k]` to `start[k + 1] - 1`, for each k."""
        verdicts = [self.balance[slice(*ends)] for ends in pairwise(start)]
        parts = zip(self.candidates.split(start), self.supports.split(start), verdicts, strict=True)
        return [StabilityResult(*part) for part in parts]


@dataclass(frozen=True)
class IslandTable:
    """Several islands as one table of N segments, without any relation across them.

    Args:
        segments: N, island after island.
        movable: (N,) bool, which are objects.
        start: where the segments of each island begin, and N.
        first, second: (P,) every pair of segments within an island.
    """

    segments: tuple[Segment, ...]
    movable: Tensor
    start: tuple[int, ...]
    first: Tensor
    second: Tensor

    @staticmethod
    def of(islands: list[Island]) -> IslandTable:
        """The table of these islands; at least one."""
        start, first, second = [0], [], []
        for island in islands:
            size = len(island.segments)
            a, b = torch.triu_indices(size, size, offset=1)
            first.append(a + start[-1])
            second.append(b + start[-1])
            start.append(start[-1] + size)
        segments = tuple(segment for island in islands for segment in island.segments)
        movable = [kind for p in islands for kind in [True] * len(p.objects) + [False] * len(p.walls)]
        return IslandTable(segments, torch.tensor(movable), tuple(start), torch.cat(first), torch.cat(second))


def island_numbers(boxes: Boxes, background: Tensor, touch: Tensor) -> Tensor:
    """Island numbers of objects: (N,) int64, the same within one island; -1 for background.

    Two objects belong together if the rectangles around their shadows on the ground, widened by `INTERACTION_M` or by
    how close they must come to touch, `touch` (N,) metres, overlap; so do those that others link.
    """
    corners = boxes.corners()[..., [0, 2]]
    low, high = corners.amin(dim=1), corners.amax(dim=1)
    reach = touch.clamp(min=INTERACTION_M)
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


def joined(parts: Sequence[Supports], names: Sequence[Sequence[int]]) -> Supports:
    """The relations of several islands as those of one scene: box i of island k is box `names[k][i]` there."""
    if not parts:
        return join([])
    whole, name = join(list(parts)), torch.tensor(list(chain.from_iterable(names)))
    start = torch.tensor([0, *accumulate(map(len, names))])[:-1]
    start = start.repeat_interleave(torch.tensor([len(part) for part in parts]))
    below = torch.where(whole.supporter == GROUND, GROUND, name[(whole.supporter + start).clamp(min=0)])
    return Supports(below, name[whole.supported + start], whole.type, whole.area)


def overlaid(verdicts: Balance, parts: Sequence[Balance], names: Sequence[Sequence[int]]) -> Balance:
    """The verdicts on a scene with those of several islands in place; box i of island k is box `names[k][i]` there.

    Background takes part in several islands: the last of them counts.
    """
    if not parts:
        return verdicts
    last = {name: i for i, name in enumerate(chain.from_iterable(names))}
    return verdicts.with_rows(torch.tensor(list(last)), concatenate(parts)[torch.tensor(list(last.values()))])
