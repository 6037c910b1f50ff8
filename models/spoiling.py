"""Random splits and merges that spoil a good segmentation, for examples of bad ones (paper, section 7.1)."""

from __future__ import annotations

from collections.abc import Callable

import torch

from blockstab.segments.atoms import Atoms
from blockstab.segments.segmentation import Segment, Segmentation

MOVE_SHARE = 0.3  # at most this share of the segments is moved

Split = Callable[[Segment], tuple[Segment, Segment] | None]


def spoil(
    start: Segmentation,
    objects: frozenset[int],
    kinds: tuple[str, ...],
    split: Split,
    atoms: Atoms,
    generator: torch.Generator,
) -> Segmentation:
    """Split and merge segments at random, between once and `MOVE_SHARE` of their number.

    Args:
        objects: atoms of objects; a segment with any other atom is never touched.
        kinds: which moves are drawn from: "split", "merge" or both.
    """
    count = sum(s <= objects for s in start.segments)
    moves = 1 + _draw(max(1, round(MOVE_SHARE * count)), generator)
    now = start
    for _ in range(moves):
        kind = kinds[_draw(len(kinds), generator)]
        step = _split_one if kind == "split" else _merge_one
        now = step(now, objects, split, atoms, generator)
    return now


def _split_one(
    now: Segmentation, objects: frozenset[int], split: Split, atoms: Atoms, generator: torch.Generator
) -> Segmentation:
    possible = [i for i, s in enumerate(now.segments) if s <= objects and len(s) > 1]
    if not possible:
        return now
    index = possible[_draw(len(possible), generator)]
    parts = split(now.segments[index])
    return now if parts is None else now.replace(index, parts)


def _merge_one(
    now: Segmentation, objects: frozenset[int], split: Split, atoms: Atoms, generator: torch.Generator
) -> Segmentation:
    first, second = now.neighbours(atoms)
    pairs = [
        (a, b)
        for a, b in zip(first.tolist(), second.tolist(), strict=True)
        if now.segments[a] <= objects and now.segments[b] <= objects
    ]
    return now.merge(*pairs[_draw(len(pairs), generator)]) if pairs else now


def _draw(below: int, generator: torch.Generator) -> int:
    return int(torch.randint(0, below, (1,), generator=generator))
