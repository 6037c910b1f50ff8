"""Segmentations of the blocks from which moves start, rated; and a problem with a pool of masks."""

from __future__ import annotations

from functools import cache

from blockstab.energy import Rating
from blockstab.proposals.pool import Regions
from blockstab.proposals.watershed import Watershed
from blockstab.search.problem import Problem
from blockstab.segments.segmentation import Segmentation
from tests.search.watched import blocks_view, watched
from tests.synthetic import over_split


@cache
def problem() -> Problem:
    """The blocks, with the regions of a watershed beside the nodes of the hierarchy."""
    return watched(blocks_view(), pool=Regions((Watershed(threshold=0.3),))).problem


@cache
def rating(name: str) -> Rating:
    """One of `STARTS`, rated."""
    return problem().rate([STARTS[name]])[0]


def _wall() -> Segmentation:
    """The truth, but of the largest block it is told that it is background."""
    truth = blocks_view().start
    return truth.telling({max(truth.segments[1:], key=problem().pixel_count): True})


def _heaps(size: int) -> Segmentation:
    """The table, and each so many blocks as one object."""
    table, *blocks = blocks_view().start.segments
    heaps = [frozenset().union(*blocks[k : k + size]) for k in range(0, len(blocks), size)]
    return Segmentation((table, *sorted(heaps, key=min)), blocks_view().start.told)


STARTS = {
    "truth": blocks_view().start,
    "pieces": over_split(blocks_view()),
    "heap": _heaps(4),
    "two heaps": _heaps(2),
    "wall": _wall(),
    "untold": Segmentation(over_split(blocks_view()).segments),
}
