"""Several moves from one segmentation, made at once."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from blockstab.energy import Rating
from blockstab.search import rank
from blockstab.segments.segmentation import Segment, Segmentation


class Exchange(NamedTuple):
    """Exchange of segments by a move: those that go, and those that come, which cover the same atoms.

    A segment that is told to be something else than before is among both.
    """

    gone: frozenset[Segment]
    come: frozenset[Segment]


def exchange(before: Segmentation, after: Segmentation) -> Exchange:
    """The exchange from one segmentation to another of the same atoms."""
    old, new = ({(s, one.background.get(s)) for s in one.segments} for one in (before, after))
    return Exchange(*(frozenset(s for s, _ in some) for some in (old - new, new - old)))


def combined(parent: Rating, children: Sequence[Rating], most: int) -> Segmentation | None:
    """The moves that lower a parent's energy, made at once where they change different segments.

    An energy that is a sum over segments falls by the sum of what each of them gains; one that looks at neighbours
    may do otherwise, so the result must be rated.

    Args:
        children: each one move from `parent`; those that gain most come first.
        most: moves that are made at once.

    Returns:
        None where there are not two such moves.
    """
    start, taken = parent.scene.segmentation, list[tuple[Exchange, Segmentation]]()
    touched: set[Segment] = set()
    for child in sorted(children, key=rank):
        if rank(child) >= rank(parent) or len(taken) == most:
            break
        result = child.scene.segmentation
        change = exchange(start, result)
        if not touched & change.gone:
            touched |= change.gone
            taken.append((change, result))
    if len(taken) < 2:
        return None
    come = {s: result.background.get(s) for change, result in taken for s in change.come}
    told = {s: b for s, b in come.items() if b is not None}
    kept = [s for s in start.segments if s not in touched]
    return Segmentation(tuple(sorted([*kept, *come], key=min)), start.told).telling(told)
