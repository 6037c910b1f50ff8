"""Completion of boxes where they were hidden, so that the scene stands: the least that does, if anything does."""

from __future__ import annotations

from dataclasses import dataclass, replace
from enum import StrEnum

import torch
from torch import Tensor

from blockstab.scene.growths import Growth, cost, double, lengths, single
from blockstab.scene.islands import island_numbers
from blockstab.stability.hidden_support import HiddenSupport, areas_of, hidden_support
from blockstab.stability.judges import Verdicts
from blockstab.stability.situation import Situation, Unseen
from blockstab.stability.support import Supports
from blockstab.stability.unseen import MOST_M, Hidden, grown, unseen_reach

_ROUNDS = 3  # what one completion mends may be what another hung on
_MOST_OPTIONS = 600  # are asked about, the likeliest first
_AT_ONCE = 64  # before the next are asked about


class Verdict(StrEnum):
    """Verdict on a thing of which not all was seen."""

    BACKGROUND = "background"
    STABLE = "stable"  # as it was seen
    COMPLETED = "completed"  # with parts that were hidden
    HIDDEN_SUPPORT = "hidden_support"  # on something that was hidden
    UNSTABLE = "unstable"  # whatever was hidden


@dataclass(frozen=True)
class Completion:
    """N boxes completed, and judged.

    Args:
        situation: with the completed boxes in place.
        added: (N, 6) metres by which each face went on unseen.
        unseen: by box, what carries it and was not seen.
        candidates: all relations that nearness allows now.
        verdicts: the supports that count now, and which boxes stand.
        verdict: N, why.
    """

    situation: Situation
    added: Tensor
    unseen: dict[int, HiddenSupport]
    candidates: Supports
    verdicts: Verdicts
    verdict: tuple[Verdict, ...]


def completed(situation: Situation, hidden: Hidden) -> Completion:
    """Complete boxes inside what was hidden, least change first, until the scene stands or nothing helps.

    A thing that does not stand as it was seen may go on, beyond one face or two, as far as the camera could not see
    and there is room; so may what is beneath it. Of all lengths with which it stands, and nothing else falls, the
    likeliest are taken. What still does not stand may be carried by something hidden.
    """
    first, added = situation, torch.zeros(len(situation.boxes), 6, dtype=torch.float64)
    futile = set[tuple[int, tuple[int, ...], bytes]]()  # things, and the boxes among which nothing helps them
    for _ in range(_ROUNDS):
        before = added
        for island in _falling_islands(situation):
            for i in _falling(situation, island):
                tried = (i, tuple(island.tolist()), added[island].numpy().tobytes())
                if tried in futile:
                    continue
                part = _mended(situation.part(island), int((island == i).nonzero()), hidden)
                if part is None:
                    futile.add(tried)
                else:
                    added = added.index_add(0, island, part)
                    situation = replace(situation, boxes=grown(first.boxes, added))
        if torch.equal(before, added):
            break
    unseen = dict[int, HiddenSupport]()
    for _ in range(_ROUNDS):
        found = _carried_unseen(situation, hidden)
        if not found:
            break
        unseen.update(found)
        supported = torch.tensor(list(unseen))
        situation = replace(situation, unseen=Unseen(supported, areas_of(list(unseen.values()))))
    candidates = situation.candidates()
    verdicts = situation.verdicts(candidates)
    return Completion(
        situation,
        added,
        unseen,
        candidates,
        verdicts,
        _why(situation, added, unseen, verdicts.balance.stable),
    )


def _falling_islands(situation: Situation) -> list[Tensor]:
    """Boxes that may touch once they are completed, with all background, of which some do not stand; box indices."""
    falls = ~situation.verdicts().balance.stable & situation.movable
    number = island_numbers(situation.boxes, ~situation.movable, torch.full((len(falls),), MOST_M / 2))
    shaky = torch.unique(number[falls])
    return [((number == k) | ~situation.movable).nonzero()[:, 0] for k in shaky]


def _falling(situation: Situation, island: Tensor) -> list[int]:
    """Things of an island that do not stand, lowest first."""
    falls = ~situation.verdicts().balance.stable & situation.movable
    height = situation.boxes.center[:, 1]
    return sorted(island[falls[island]].tolist(), key=lambda i: (float(height[i]), i))


def _mended(situation: Situation, i: int, hidden: Hidden) -> Tensor | None:
    """The least that must be added to faces, (N, 6) metres, so that box i stands and nothing else falls.

    What is beneath it may go on too, for a thing of which one face was seen carries more than can be seen.
    """
    stands_now = situation.verdicts().balance.stable
    if bool(stands_now[i]):
        return None  # by what was mended before it
    grows = [i, *_beneath(situation, i)]
    reach = unseen_reach(
        situation.boxes, torch.tensor(grows), hidden, ~situation.is_ground, situation.ground_height
    )
    found = [
        Growth(j, face, some)
        for j, row in zip(grows, reach, strict=True)
        for face, some in enumerate(lengths(situation, j, row))
        if len(some)
    ]
    for make in (single, double):
        options = make(found, len(situation.boxes))
        options = options[cost(situation.boxes, options).argsort(stable=True)][:_MOST_OPTIONS]
        for some in torch.split(options, _AT_ONCE):
            stands = situation.standing_with(some)
            good = stands[:, i] & (stands | ~stands_now).all(dim=1)
            if bool(good.any()):
                return some[int(good.nonzero()[0, 0])]
    return None


def _beneath(situation: Situation, i: int) -> list[int]:
    """Things whose top is near the bottom of box i, and whose shadow is near its own."""
    corners = situation.boxes.corners()
    low, high = corners.amin(dim=1), corners.amax(dim=1)
    touch = situation.rules.touch(situation.boxes)
    near = (low <= high[i] + MOST_M) & (low[i] - MOST_M <= high)
    near = near[:, 0] & near[:, 2] & ((high[:, 1] - low[i, 1]).abs() < 2 * touch) & situation.movable
    near[i] = False
    return near.nonzero()[:, 0].tolist()


def _carried_unseen(situation: Situation, hidden: Hidden) -> dict[int, HiddenSupport]:
    """What may carry the things that do not stand, unseen."""
    candidates = situation.candidates()
    balance = situation.verdicts(candidates).balance
    known, found = situation.unseen.supported.tolist(), {}
    for i in (~balance.stable & situation.movable).nonzero()[:, 0].tolist():
        if i in known:
            continue
        held = candidates.area[candidates.supported == i]
        one = hidden_support(
            situation.boxes, i, hidden, held, balance.mass_center[i], situation.ground_height
        )
        if one is not None:
            found[i] = one
    return found


def _why(
    situation: Situation, added: Tensor, unseen: dict[int, HiddenSupport], stable: Tensor
) -> tuple[Verdict, ...]:
    def of(i: int) -> Verdict:
        if not bool(situation.movable[i]):
            return Verdict.BACKGROUND
        if not bool(stable[i]):
            return Verdict.UNSTABLE
        if i in unseen:
            return Verdict.HIDDEN_SUPPORT
        return Verdict.COMPLETED if bool((added[i] > 0).any()) else Verdict.STABLE

    return tuple(of(i) for i in range(len(situation.boxes)))
