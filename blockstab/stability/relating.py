"""Supports that nearness allows between many boxes, in machine code: what a search asks for thousands of times."""

from __future__ import annotations

import math

import torch
from torch import Tensor

from blockstab.boxes.box import Boxes
from blockstab.boxes.separation import Separation, separation
from blockstab.geometry.convex_hulls import Polygons
from blockstab.stability.support import SupportRules, Supports


def related(
    boxes: Boxes,
    pairs: tuple[Tensor, Tensor],
    apart: Separation,
    ground_height: Tensor,
    movable: Tensor,
    is_ground: Tensor,
    rules: SupportRules,
) -> Supports:
    """The same as `candidate_supports`, whose arguments these are, but far faster; nothing can be differentiated.

    Everything is float64 on the CPU.
    """
    # Importing numba takes half a second, and most of the package does without it.
    from blockstab.stability.compiled.islands import candidates
    from blockstab.stability.compiled.things import Given, Limits, Pairs, arrays

    found = candidates(
        Given(*arrays(boxes.center, boxes.rotation, boxes.half_extent, ground_height, movable, is_ground)),
        Pairs(*arrays(*pairs, *apart)),
        Limits(math.radians(rules.angle_deg), rules.touch_m, rules.touch_per_square_m),
    )
    supporter, supported, kind, vertices, count = map(torch.from_numpy, found)
    return Supports(supporter, supported, kind, Polygons(vertices, count))


def related_on(
    ground_height: float,
    boxes: Boxes,
    pairs: tuple[Tensor, Tensor],
    movable: Tensor,
    is_ground: Tensor,
    rules: SupportRules,
) -> Supports:
    """The same on a ground that is as high everywhere, with the gaps of the pairs measured here."""
    height = torch.full((len(boxes),), ground_height, dtype=torch.float64)
    return related(boxes, pairs, separation(boxes, *pairs), height, movable, is_ground, rules)
