"""Random splits and merges, the worse the likelier (paper, section 7.2)."""

from __future__ import annotations

from collections.abc import Callable

import torch
from torch import Tensor

from blockstab.energy import Rating
from blockstab.features.pairwise import boundaries
from blockstab.segments.segmentation import Segment, Segmentation

_FLOOR = 0.05  # even the best segment may be split now and then


def split_moves(
    rating: Rating,
    split: Callable[[Segment], tuple[Segment, Segment] | None],
    count: int,
    generator: torch.Generator,
) -> list[Segmentation]:
    """Split objects of the scene in two, `count` times, drawn by their unary potential; never background."""
    segmentation = rating.scene.segmentation
    possible = torch.tensor([len(s) > 1 for s in segmentation.segments]) & ~rating.scene.background
    results = []
    for index in _draw(rating.unary, possible, count, generator):
        parts = split(segmentation.segments[index])
        if parts is not None:
            results.append(segmentation.replace(index, parts))
    return results


def merge_moves(rating: Rating, count: int, generator: torch.Generator) -> list[Segmentation]:
    """Merge neighbouring objects of the scene, `count` times, drawn by their pairwise potential; never background."""
    first, second = boundaries(rating.scene)
    possible = torch.ones(len(first), dtype=torch.bool)
    drawn = _draw(rating.pairwise, possible, count, generator)
    return [rating.scene.segmentation.merge(int(first[k]), int(second[k])) for k in drawn]


def _draw(potential: Tensor, possible: Tensor, count: int, generator: torch.Generator) -> list[int]:
    """Draw indices with a probability that grows linearly with the potential."""
    index = possible.nonzero()[:, 0]
    if not len(index):
        return []
    value = potential[index]
    low, high = value.min(), value.max()
    weight = (value - low) / (high - low).clamp(min=1e-12) + _FLOOR
    return index[torch.multinomial(weight, count, replacement=True, generator=generator)].tolist()
