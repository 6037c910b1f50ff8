"""Random draws of moves: the worse what they change, or the more they promise, the likelier."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from typing import NamedTuple

import torch
from torch import Tensor

from blockstab.energy import Rating
from blockstab.search.problem import Problem
from blockstab.segments.segmentation import Segment, Segmentation

_FLOOR = 0.05  # even the best segment may be split now and then
_DIGITS = 9  # as in `search.rank`
_KEEN = (
    4.0  # how much likelier the most promising change is drawn than one half as promising: 2 to this power
)


class Change(NamedTuple):
    """Change that a move would make.

    Args:
        gone, new: the segments that go, and those that come; they cover the same atoms.
        result: gives the segmentation after it.
        objects: those of `new` that are told to be objects.
    """

    gone: tuple[Segment, ...]
    new: tuple[Segment, ...]
    result: Callable[[], Segmentation]
    objects: frozenset[Segment] = frozenset()


def draw(potential: Tensor, possible: Tensor, count: int, generator: torch.Generator) -> list[int]:
    """Draw indices with a probability that grows linearly with the potential (paper, section 7.2)."""
    index = possible.nonzero()[:, 0]
    if not len(index):
        return []
    value = potential.detach()[index].double().round(decimals=_DIGITS)
    low, high = value.min(), value.max()
    weight = (value - low) / (high - low).clamp(min=1e-12) + _FLOOR
    return index[torch.multinomial(weight, count, replacement=True, generator=generator)].tolist()


class MostPromising(ABC):
    """A move that draws among all its changes by what they promise: what segments by themselves lose before, less
    what they lose after.

    A segment by itself is judged fast, from its contour and surface; what stands on what is found out for those
    changes alone that are drawn. A particle that stays in the pool is asked again, and promises what it did before.
    """

    @abstractmethod
    def changes(self, rating: Rating, problem: Problem) -> Sequence[Change]:
        """All that the move could do to a segmentation; always the same."""

    def __call__(
        self, rating: Rating, problem: Problem, count: int, generator: torch.Generator
    ) -> list[Segmentation]:
        """At most `count` segmentations."""
        key = (self, rating.scene.segmentation)
        changes, weight = problem.once(key, lambda: _weighed(self.changes(rating, problem), rating, problem))
        if not changes:
            return []
        amount = min(count, len(changes))
        drawn = torch.multinomial(weight, amount, replacement=False, generator=generator)
        return [changes[k].result() for k in drawn.tolist()]


def _weighed(found: Sequence[Change], rating: Rating, problem: Problem) -> tuple[list[Change], Tensor]:
    """Changes, each once, and how likely each is drawn."""
    changes = list({(frozenset(change.new), change.objects): change for change in found}.values())
    if not changes:
        return changes, torch.empty(0)
    before = _losses(rating, problem)
    new = list(dict.fromkeys(segment for change in changes for segment in change.new))
    after = dict(zip(new, problem.losses(new), strict=True))
    gain = torch.tensor(
        [sum(before[s] for s in c.gone) - sum(after[s] for s in c.new) for c in changes], dtype=torch.float64
    ).round(decimals=6)
    scale = (gain.amax() - gain.median()).clamp(min=1.0)
    return changes, ((gain - gain.amax()) / scale * _KEEN).exp2().clamp(min=1e-12)


def _losses(rating: Rating, problem: Problem) -> dict[Segment, float]:
    """Pixels that each segment of a scene is expected to lose, by itself; background loses the things in it."""
    scene = rating.scene
    segments = scene.segmentation.segments
    alone = torch.tensor(problem.losses(segments), dtype=torch.float64)
    lost = problem.describe.lost(scene) * scene.pixel_count
    return dict(zip(segments, torch.where(scene.background, lost, alone).tolist(), strict=True))
