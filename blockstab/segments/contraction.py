"""Regions that border on each other, merged one pair at a time."""

from __future__ import annotations

import heapq
from collections.abc import Iterator

from torch import Tensor

Borders = dict[int, dict[int, tuple[float, float]]]
"""For each region its neighbours, and for each of those the length of the shared border (pixels) and the sum
of the boundary strength along it. Both regions list a border."""


def borders_between(
    count: int, first: Tensor, second: Tensor, border_px: Tensor, strength: Tensor
) -> Borders:
    """Borders of regions 0 to `count - 1`; the e-th lies between `first[e]` and `second[e]`."""
    borders: Borders = {region: {} for region in range(count)}
    rows = zip(first.tolist(), second.tolist(), border_px.tolist(), strength.tolist(), strict=True)
    for i, j, length, mean in rows:
        borders[i][j] = borders[j][i] = (length, length * mean)
    return borders


def contract(borders: Borders, kept: int, gone: int) -> None:
    """Merge region `gone` into its neighbour `kept`, in place; borders to a common neighbour become one."""
    del borders[kept][gone]
    for other, (length, total) in borders.pop(gone).items():
        if other == kept:
            continue
        del borders[other][gone]
        if other in borders[kept]:
            more_length, more_total = borders[kept][other]
            length, total = length + more_length, total + more_total
        borders[kept][other] = borders[other][kept] = (length, total)


def lowest_first(borders: Borders) -> Iterator[tuple[int, int, float]]:
    """Merge across the weakest border, time and again, while any is left; `borders` is used up.

    Yields:
        Before each merge: the region that stays (the smaller index), the one that goes, and the mean strength
        of the border between them. Of equal borders the one between the smallest indices comes first.
    """
    heap = [(t / n, i, j) for i, row in borders.items() for j, (n, t) in row.items() if i < j]
    heapq.heapify(heap)
    while heap:
        mean, kept, gone = heapq.heappop(heap)
        length, total = borders.get(kept, {}).get(gone, (1.0, -1.0))
        if total / length != mean:  # a border that has changed or gone since
            continue
        yield kept, gone, mean
        touched = list(borders[gone])
        contract(borders, kept, gone)
        for other in touched:
            if other != kept:
                length, total = borders[kept][other]
                heapq.heappush(heap, (total / length, min(kept, other), max(kept, other)))


def smallest_first(borders: Borders, pixels: list[int], least_px: int) -> list[int]:
    """Merge regions of fewer than `least_px` pixels across their weakest border, while they have one.

    Of equally weak borders the longest is taken. `borders` is used up.

    Returns:
        For every region the one that it became part of, possibly itself.
    """
    pixels, owner = list(pixels), list(range(len(pixels)))
    small = [(size, region) for region, size in enumerate(pixels) if size < least_px]
    heapq.heapify(small)
    while small:
        size, gone = heapq.heappop(small)
        if size != pixels[gone] or not borders.get(gone):  # grown or merged since, or alone
            continue
        weakest = min((total / length, -length, other) for other, (length, total) in borders[gone].items())
        kept = owner[gone] = weakest[2]
        contract(borders, kept, gone)
        pixels[kept] += size
        if pixels[kept] < least_px:
            heapq.heappush(small, (pixels[kept], kept))
    for region in range(len(owner)):
        while owner[owner[region]] != owner[region]:
            owner[region] = owner[owner[region]]
    return owner
