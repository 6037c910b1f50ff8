"""Supports and verdicts of many boxes at once, in machine code: what a search asks for thousands of times."""

from __future__ import annotations

import math
from typing import Any

import torch
from torch import Tensor

from blockstab.boxes.box import Boxes
from blockstab.boxes.separation import Separation
from blockstab.geometry.convex_hulls import Polygons
from blockstab.stability.balance import Balance
from blockstab.stability.support import SupportRules, Supports


def judge(
    boxes: Boxes,
    pairs: tuple[Tensor, Tensor],
    apart: Separation,
    ground_height: Tensor,
    movable: Tensor,
    is_ground: Tensor,
    rules: SupportRules,
    slack: Tensor,
    trimming: bool = True,
) -> tuple[Supports, Supports, Balance]:
    """Relate boxes, drop what stability does not need, and judge them.

    The same as `candidate_supports`, `trim` (unless `trimming` is false) and `balance` one after the other, whose
    arguments these are, but far faster, and nothing can be differentiated. Everything is float64 on the CPU.

    Returns:
        the candidates, those of them that count, and the verdicts.
    """
    # Importing numba takes half a second, and most of the package does without it.
    from blockstab.stability.compiled.islands import judged
    from blockstab.stability.compiled.things import Given, Limits, Pairs

    found, kept, verdicts = judged(
        Given(
            *_arrays(
                boxes.center, boxes.rotation, boxes.half_extent, slack, ground_height, movable, is_ground
            )
        ),
        Pairs(*_arrays(*pairs, *apart)),
        Limits(math.radians(rules.angle_deg), rules.touch_m, rules.touch_per_square_m),
        trimming,
    )
    supporter, supported, kind, vertices, count = map(torch.from_numpy, found)
    candidates = Supports(supporter, supported, kind, Polygons(vertices, count))
    supports = candidates[torch.from_numpy(kept)]
    return candidates, supports, Balance(*map(torch.from_numpy, verdicts))


def warm_up() -> None:
    """Judge one box, so that the machine code is there when it is wanted."""
    center = torch.tensor([[0.0, 0.1, 1.0]], dtype=torch.float64)
    box = Boxes(center, torch.eye(3, dtype=torch.float64)[None], torch.full_like(center, 0.1))
    none, zero, true = torch.empty(0, dtype=torch.long), center.new_zeros(1), torch.tensor([True])
    apart = Separation(center.new_empty(0), center.new_empty(0, 3))
    judge(box, (none, none), apart, zero, true, ~true, SupportRules(), zero)


def _arrays(*tensors: Tensor) -> list[Any]:
    # Machine code is made for one layout in memory.
    return [tensor.detach().contiguous().numpy() for tensor in tensors]
