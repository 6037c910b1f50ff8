"""Growths of boxes into what was hidden: which lengths are tried, and how likely each is."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations
from typing import NamedTuple

import torch
from torch import Tensor

from blockstab.boxes.box import Boxes
from blockstab.stability.situation import Situation
from blockstab.stability.unseen import MOST_M, STEP_M

_COARSE = 5  # lengths that are tried of each of two faces at once
_LONGEST = 2.0  # times its greatest edge, a box becomes along no axis but downward


class Growth(NamedTuple):
    """Growth of one face of a box, by any of some lengths, metres."""

    box: int
    face: int
    lengths: Tensor


def lengths(situation: Situation, i: int, reach: Tensor) -> list[Tensor]:
    """Lengths that are tried of each face: steps of what is hidden; downward, just as far as what is beneath."""
    box = situation.boxes[[i]]
    greatest = 2.0 * float(box.half_extent.amax())
    downward = -box.face_normals()[0, :, 1]
    down = int(downward.argmax())
    found = []
    for face in range(6):
        most = float(reach[face])
        if face == down:
            drop = _drops(situation, i) / downward[down].clamp(min=0.5)
            found.append(drop[drop <= most + STEP_M])
        else:
            edge = 2.0 * float(box.half_extent[0, face // 2])
            steps = torch.arange(1, round(MOST_M / STEP_M) + 1, dtype=torch.float64) * STEP_M
            found.append(steps[(steps <= most + 1e-9) & (steps + edge <= _LONGEST * greatest)])
    return found


def _drops(situation: Situation, i: int) -> Tensor:
    """How far below box i the tops of other boxes lie, and the ground, metres; ascending."""
    corners = situation.boxes.corners()[..., 1]
    bottom = corners[i].amin()
    tops = torch.cat([corners.amax(dim=1), torch.tensor([situation.ground_height], dtype=torch.float64)])
    drop = (bottom - tops)[tops < bottom - STEP_M / 2]
    return drop.sort().values


def single(growths: Sequence[Growth], n: int) -> Tensor:
    """(K, N, 6) metres that are added to the faces of N boxes: every length of every growth."""
    rows = [torch.zeros(0, n, 6, dtype=torch.float64)]
    for growth in growths:
        one = torch.zeros(len(growth.lengths), n, 6, dtype=torch.float64)
        one[:, growth.box, growth.face] = growth.lengths
        rows.append(one)
    return torch.cat(rows)


def double(growths: Sequence[Growth], n: int) -> Tensor:
    """(K, N, 6) the same: a few lengths of every two growths."""
    rows = [torch.zeros(0, n, 6, dtype=torch.float64)]
    for one, other in combinations(growths, 2):
        pair = torch.cartesian_prod(_few(one.lengths), _few(other.lengths)).view(-1, 2)
        both = torch.zeros(len(pair), n, 6, dtype=torch.float64)
        both[:, one.box, one.face] = pair[:, 0]
        both[:, other.box, other.face] = pair[:, 1]
        rows.append(both)
    return torch.cat(rows)


def _few(some: Tensor) -> Tensor:
    return some[torch.linspace(0, len(some) - 1, min(_COARSE, len(some))).round().long()]


def cost(boxes: Boxes, added: Tensor) -> Tensor:
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
