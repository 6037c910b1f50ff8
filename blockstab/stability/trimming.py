"""Drop the supports that stability does not need (paper, section 6, "Support reasoning")."""

from __future__ import annotations

from functools import cache
from itertools import combinations

import torch
from torch import Tensor

from blockstab.boxes.box import Boxes
from blockstab.geometry.convex_hulls import area, centroid
from blockstab.stability.area import on_ground
from blockstab.stability.balance import combined, margins, mass_centers, slots_of
from blockstab.stability.loads import levels, pass_down
from blockstab.stability.support import Supports, SupportType

TOP_SLOTS, SIDE_SLOTS = 4, 4  # supports of one box that are tried in combination; more are never seen
MAX_SIDES = 2  # "at most two side supports"


def trim(boxes: Boxes, candidates: Supports, slack: Tensor) -> Supports:
    """Keep, for each box from the top down, the supports that make it stand.

    Surface supports alone, if they suffice. Else the smallest combination of on-top supports and at most two
    side supports that does; among equals the one whose hull holds the centre of mass most centrally, then the
    larger hull. Where no combination suffices, or all candidates together do not, all are kept.

    The load of a box is what the boxes above it were found to rest on, so the order matters: a box is judged
    after everything that may rest on it.

    Args:
        boxes: N boxes; candidates: relations between them; slack: (N,) metres, as in `balance`.
    """
    n = len(boxes)
    level = levels(*candidates.resting(), n)
    slots, used = slots_of(candidates, n)
    kind = candidates.type[slots].masked_fill(~used, -1) if len(candidates) else torch.full_like(slots, -1)
    kept = torch.zeros_like(used)
    load = torch.eye(n, dtype=torch.bool)
    for height in range(int(level.max()) + 1 if n else 0):
        now = (level == height).nonzero()[:, 0]
        center = mass_centers(boxes, load[now])
        kept[now] = _needed(candidates, slots[now], used[now], kind[now], center, slack[now])
        carrying = candidates[slots[now][kept[now]]]
        pass_down(load, *carrying.resting())
    flat = slots[kept]
    return candidates[flat.sort().values]


def _needed(
    candidates: Supports, slots: Tensor, used: Tensor, kind: Tensor, center: Tensor, slack: Tensor
) -> Tensor:
    """(K, S) which supports of K boxes to keep."""
    surface = used & (kind == SupportType.SURFACE)
    by_surface = margins(combined(candidates.area, slots, surface), center) >= -slack
    kept = torch.where(by_surface[:, None], surface, used)
    # An edge alone reaches a little further than a hull with area (see `margins`): what all candidates together
    # cannot hold shall not stand on one of them.
    rows = (~by_surface).nonzero()[:, 0]
    rows = rows[margins(combined(candidates.area, slots[rows], used[rows]), center[rows]) >= -slack[rows]]
    if len(rows):
        part = (column[rows] for column in (slots, used, kind, center, slack))
        kept[rows] = _smallest_combination(candidates, *part)
    return kept


def _smallest_combination(
    candidates: Supports, slots: Tensor, used: Tensor, kind: Tensor, center: Tensor, slack: Tensor
) -> Tensor:
    """(K, S) the smallest stable combination of each box's supports; all of them where none is stable."""
    order = _by_importance(used, kind)  # (K, 8): on-top first, then side; -1 is none
    result, rows = used.clone(), torch.arange(len(used))
    for size in range(1, TOP_SLOTS + MAX_SIDES + 1):
        tries = order[rows][:, combinations_of(size)]  # (R, T, size)
        pick = _most_central(candidates, slots[rows], tries, center[rows], slack[rows])
        found = pick >= 0
        chosen = tries[torch.arange(len(rows)), pick.clamp(min=0)][found]
        solved = torch.zeros_like(used[rows[found]])
        result[rows[found]] = solved.scatter(1, chosen, True)
        rows = rows[~found]
        if not len(rows):
            break
    return result


def _most_central(
    candidates: Supports, slots: Tensor, tries: Tensor, center: Tensor, slack: Tensor
) -> Tensor:
    """(R,) of the combinations `tries` (R, T, size), the stable one that holds the centre of mass most centrally,
    then on the largest hull; -1 where none is stable."""
    r, t, size = tries.shape
    real = (tries >= 0).all(dim=2).flatten().nonzero()[:, 0]
    owner = real // t
    edges = slots[owner[:, None], tries.view(-1, size)[real]]
    held = combined(candidates.area, edges, torch.ones_like(edges, dtype=torch.bool))
    stable = margins(held, center[owner]) >= -slack[owner]
    off_center = torch.full((r * t,), float("inf"), dtype=center.dtype)
    distance = (centroid(held) - on_ground(center[owner])).norm(dim=-1).round(decimals=9)
    off_center[real[stable]] = distance[stable]
    size_of_hull = torch.full((r * t,), -1.0, dtype=center.dtype)
    size_of_hull[real[stable]] = area(held)[stable]
    off_center, size_of_hull = off_center.view(r, t), size_of_hull.view(r, t)
    least = off_center.amin(dim=1, keepdim=True)
    best = size_of_hull.masked_fill(off_center > least, -2.0).argmax(dim=1)
    return torch.where(least[:, 0].isfinite(), best, -1)


def _by_importance(used: Tensor, kind: Tensor) -> Tensor:
    """(K, 8) places of the on-top supports, then of the side supports, in their order; -1 for none."""
    columns = []
    for wanted, amount in ((kind != SupportType.SIDE, TOP_SLOTS), (kind == SupportType.SIDE, SIDE_SLOTS)):
        none = used.shape[1]
        place = torch.where(used & wanted, torch.arange(none), none).sort(dim=1).values
        place = torch.nn.functional.pad(place, (0, amount), value=none)[:, :amount]
        columns.append(torch.where(place < none, place, -1))
    return torch.cat(columns, dim=1)


@cache
def combinations_of(size: int) -> Tensor:
    """(T, size) every set of so many of the 8 places, with at most two of the side supports."""
    places = range(TOP_SLOTS + SIDE_SLOTS)
    rows = [c for c in combinations(places, size) if sum(k >= TOP_SLOTS for k in c) <= MAX_SIDES]
    return torch.tensor(rows)
