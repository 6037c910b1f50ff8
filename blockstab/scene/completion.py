"""Completion of boxes where they were hidden, so that the scene stands: the least that does, if anything does."""

from __future__ import annotations

from dataclasses import dataclass, replace
from enum import StrEnum
from itertools import combinations

import torch
from torch import Tensor

from blockstab.boxes.box import Boxes
from blockstab.scene.islands import island_numbers
from blockstab.stability.hidden_support import HiddenSupport, areas_of, hidden_support
from blockstab.stability.judges import Verdicts
from blockstab.stability.situation import Situation, Unseen
from blockstab.stability.support import Supports
from blockstab.stability.unseen import MOST_M, STEP_M, Hidden, grown, unseen_reach

_ROUNDS = 3  # what one completion mends may be what another hung on
_COARSE = 5  # lengths that are tried of each of two faces at once
_MOST_OPTIONS = 600  # are asked about, the likeliest first
_LONGEST = 2.0  # times its greatest edge, a box becomes along no axis but downward


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
    and there is room. Of all lengths with which it stands, and nothing else falls, the shortest is taken. What still
    does not stand may be carried by something hidden.
    """
    first, added = situation, torch.zeros(len(situation.boxes), 6, dtype=torch.float64)
    for _ in range(_ROUNDS):
        before = added
        for island in _falling_islands(situation):
            for i in _falling(situation, island):
                part = _mended(situation.part(island), int((island == i).nonzero()), hidden)
                if part is not None:
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
    own = [(i, face, some) for face, some in enumerate(_lengths(situation, i, reach[0]))]
    theirs = [
        (j, face, some)
        for j, row in zip(grows[1:], reach[1:], strict=True)
        for face, some in enumerate(_lengths(situation, j, row))
    ]
    singles = [one for one in own + theirs if len(one[2])]
    for options in (_single(situation, singles), _double(situation, singles)):
        if not len(options):
            continue
        options = options[_cost(situation.boxes, options).argsort(stable=True)][:_MOST_OPTIONS]
        stands = situation.standing_with(options)
        good = stands[:, i] & (stands | ~stands_now).all(dim=1)
        if bool(good.any()):
            return options[int(good.nonzero()[0, 0])]
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


def _lengths(situation: Situation, i: int, reach: Tensor) -> list[Tensor]:
    """Lengths that are tried of each face: steps of what is hidden; downward, just as far as what is beneath."""
    box = situation.boxes[[i]]
    greatest = 2.0 * float(box.half_extent.amax())
    downward = -box.face_normals()[0, :, 1]
    down = int(downward.argmax())
    lengths = []
    for face in range(6):
        most = float(reach[face])
        if face == down:
            drop = _drops(situation, i) / downward[down].clamp(min=0.5)
            lengths.append(drop[drop <= most + STEP_M])
        else:
            edge = 2.0 * float(box.half_extent[0, face // 2])
            steps = torch.arange(1, round(MOST_M / STEP_M) + 1, dtype=torch.float64) * STEP_M
            lengths.append(steps[(steps <= most + 1e-9) & (steps + edge <= _LONGEST * greatest)])
    return lengths


def _drops(situation: Situation, i: int) -> Tensor:
    """How far below box i the tops of other boxes lie, and the ground, metres; ascending."""
    corners = situation.boxes.corners()[..., 1]
    bottom = corners[i].amin()
    tops = torch.cat([corners.amax(dim=1), torch.tensor([situation.ground_height], dtype=torch.float64)])
    drop = (bottom - tops)[tops < bottom - STEP_M / 2]
    return drop.sort().values


_Growth = tuple[int, int, Tensor]  # a box, one of its faces, and lengths


def _single(situation: Situation, growths: list[_Growth]) -> Tensor:
    """(K, N, 6) every length of every growth."""
    rows = [torch.zeros(0, len(situation.boxes), 6, dtype=torch.float64)]
    for j, face, some in growths:
        one = torch.zeros(len(some), len(situation.boxes), 6, dtype=torch.float64)
        one[:, j, face] = some
        rows.append(one)
    return torch.cat(rows)


def _double(situation: Situation, growths: list[_Growth]) -> Tensor:
    """(K, N, 6) a few lengths of every two growths."""
    rows = [torch.zeros(0, len(situation.boxes), 6, dtype=torch.float64)]
    for (a, face, some), (b, other, more) in combinations(growths, 2):
        pair = torch.cartesian_prod(_few(some), _few(more)).view(-1, 2)
        both = torch.zeros(len(pair), len(situation.boxes), 6, dtype=torch.float64)
        both[:, a, face] += pair[:, 0]
        both[:, b, other] += pair[:, 1]
        rows.append(both)
    return torch.cat(rows)


def _few(lengths: Tensor) -> Tensor:
    return lengths[torch.linspace(0, len(lengths) - 1, min(_COARSE, len(lengths))).round().long()]


def _cost(boxes: Boxes, added: Tensor) -> Tensor:
    """(K,) how unlikely it is that so much goes on unseen: metres, half of them where a slab becomes a body.

    A thin slab is the least likely reading of a single face, so up to the middle one of its edges a box becomes
    thicker at half the price; beyond the greatest of them it becomes longer at double the price.
    """
    edges = 2.0 * boxes.half_extent
    middle, greatest = edges.median(dim=1, keepdim=True).values, edges.amax(dim=1, keepdim=True)
    after = edges + added[..., 0::2] + added[..., 1::2]
    body = (after.clamp(max=middle) - edges).clamp(min=0.0)
    beyond = (after - greatest).clamp(min=0.0)
    return (after - edges - body / 2 + beyond).sum(dim=(1, 2))


def _carried_unseen(situation: Situation, hidden: Hidden) -> dict[int, HiddenSupport]:
    """What may carry the things that do not stand, unseen."""
    candidates = situation.candidates()
    balance = situation.verdicts(candidates).balance
    found = {}
    for i in (~balance.stable & situation.movable).nonzero()[:, 0].tolist():
        held = candidates.area[candidates.supported == i]
        one = hidden_support(
            situation.boxes, i, hidden, held, balance.mass_center[i], situation.ground_height
        )
        if one is not None and i not in situation.unseen.supported.tolist():
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
