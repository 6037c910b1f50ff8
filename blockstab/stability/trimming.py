"""Drop the supports that stability does not need (paper, section 6, "Support reasoning")."""

from __future__ import annotations

from itertools import combinations, product

import torch
from torch import Tensor

from blockstab.boxes.box import Boxes
from blockstab.stability.balance import footing, levels, mass_centers, slots_of
from blockstab.stability.support import Supports, SupportType

_TOP_SLOTS, _SIDE_SLOTS = 4, 4  # supports of one box that are tried in combination; more are never seen
_MAX_SIDES = 2  # "at most two side supports"


def trim(boxes: Boxes, candidates: Supports, slack: Tensor) -> Supports:
    """Keep, for each box from the top down, the supports that make it stand.

    Surface supports alone, if they suffice. Else the smallest combination of on-top supports and at most two
    side supports that does; among equals the one whose hull holds the centre of mass most centrally, then the
    larger hull. Where nothing suffices, all are kept.

    The load of a box is what the boxes above it were found to rest on, so the order matters: a box is judged
    after everything that may rest on it.

    Args:
        boxes: N boxes; candidates: relations between them; slack: (N,) metres, as in `balance`.
    """
    n = len(boxes)
    level = levels(candidates, n)
    slots, used = slots_of(candidates, n)
    kind = candidates.type[slots].masked_fill(~used, -1) if len(candidates) else torch.full_like(slots, -1)
    kept = torch.zeros_like(used)
    load = torch.eye(n, dtype=torch.bool)
    for height in range(int(level.max()) + 1 if n else 0):
        now = (level == height).nonzero()[:, 0]
        center = mass_centers(boxes, load[now])
        kept[now] = _needed(candidates, slots[now], used[now], kind[now], center, slack[now])
        load = _passed_down(load, candidates, slots[now], kept[now] & (kind[now] != SupportType.SIDE), now)
    flat = slots[kept]
    return candidates[flat.sort().values]


def _passed_down(load: Tensor, candidates: Supports, slots: Tensor, carries: Tensor, now: Tensor) -> Tensor:
    """Add the load of the boxes `now` to that of the boxes they rest on."""
    row, column = carries.nonzero(as_tuple=True)
    below = candidates.supporter[slots[row, column]]
    row, below = row[below >= 0], below[below >= 0]
    add = torch.zeros(len(load), len(now))
    add[below, row] = 1.0
    return load | ((add @ load[now].to(add.dtype)) > 0)


def _needed(
    candidates: Supports, slots: Tensor, used: Tensor, kind: Tensor, center: Tensor, slack: Tensor
) -> Tensor:
    """(K, S) which supports of K boxes to keep."""
    surface = used & (kind == SupportType.SURFACE)
    by_surface = footing(candidates.area, slots, surface, center).margin >= -slack
    # More support never hurts: what all candidates together cannot hold, no choice of them can.
    possible = footing(candidates.area, slots, used, center).margin >= -slack
    kept = torch.where(by_surface[:, None], surface, used)
    open_question = (possible & ~by_surface).nonzero()[:, 0]
    if len(open_question):
        part = (column[open_question] for column in (slots, used, kind, center, slack))
        kept[open_question] = _smallest_combination(candidates, *part)
    return kept


def _smallest_combination(
    candidates: Supports, slots: Tensor, used: Tensor, kind: Tensor, center: Tensor, slack: Tensor
) -> Tensor:
    """(K, S) the smallest stable combination of each box's supports; all of them where none is stable."""
    order = _by_importance(candidates, slots, used, kind)  # (K, 8): on-top first, then side; -1 is none
    real = order >= 0
    chosen = _combinations() & real[:, None]  # (K, T, 8)
    valid = ((_combinations() & ~real[:, None]).sum(dim=-1) == 0) & chosen.any(dim=-1)
    near = slots.gather(1, order.clamp(min=0))
    tries = chosen.shape[1]
    held = footing(
        candidates.area,
        near[:, None].expand(-1, tries, -1).flatten(0, 1),
        chosen.flatten(0, 1),
        center[:, None].expand(-1, tries, -1).flatten(0, 1),
    )
    margin = held.margin.view(-1, tries)
    stable = valid & (margin >= -slack[:, None])
    size = chosen.sum(dim=-1).masked_fill(~stable, 99)
    smallest = size == size.amin(dim=1, keepdim=True)
    off_center = (held.center - center[:, None].expand(-1, tries, -1).flatten(0, 1)[:, [0, 2]]).norm(dim=-1)
    off_center = off_center.view(-1, tries).masked_fill(~smallest, float("inf")).round(decimals=9)
    most_central = off_center == off_center.amin(dim=1, keepdim=True)
    best = held.area.view(-1, tries).masked_fill(~most_central, -1.0).argmax(dim=1)
    pick = chosen[torch.arange(len(best)), best]  # (K, 8)
    result = torch.zeros_like(used)
    rows, places = (pick & real).nonzero(as_tuple=True)
    result[rows, order[rows, places]] = True
    return torch.where(stable.any(dim=1)[:, None], result, used)


def _by_importance(candidates: Supports, slots: Tensor, used: Tensor, kind: Tensor) -> Tensor:
    """Slots of the on-top supports, then of the side supports, in the order of their candidates."""
    columns = []
    for wanted, amount in ((kind != SupportType.SIDE, _TOP_SLOTS), (kind == SupportType.SIDE, _SIDE_SLOTS)):
        take = used & wanted
        place = torch.where(take, torch.arange(take.shape[1]), take.shape[1]).sort(dim=1).values
        place = torch.nn.functional.pad(place, (0, amount), value=take.shape[1])[:, :amount]
        columns.append(torch.where(place < take.shape[1], place, -1))
    return torch.cat(columns, dim=1)


def _combinations() -> Tensor:
    """(T, 8) every set of on-top supports with every set of at most two side supports."""
    sides = [c for size in range(_MAX_SIDES + 1) for c in combinations(range(_SIDE_SLOTS), size)]
    rows = [
        [*top, *(k in side for k in range(_SIDE_SLOTS))]
        for top in product((False, True), repeat=_TOP_SLOTS)
        for side in sides
    ]
    return torch.tensor(rows)
