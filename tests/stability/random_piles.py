"""Random islands of boxes: in exact contact, turned, nearly in contact, and any others."""

from __future__ import annotations

import math
from typing import NamedTuple

import torch
from torch import Tensor

from blockstab.boxes.box import Boxes, concatenate
from blockstab.boxes.separation import Separation, separation

KINDS = ("in contact", "in contact, turned", "nearly in contact", "any")
_CELL = 0.025  # metres
_ALONG_GROUND = torch.tensor([1.0, 0.0, 1.0], dtype=torch.float64)


class Table(NamedTuple):
    """Several islands without a pair across them; the arguments of `candidate_supports` but for the rules."""

    boxes: Boxes
    pairs: tuple[Tensor, Tensor]
    apart: Separation
    ground_height: Tensor
    movable: Tensor
    is_ground: Tensor


def table(kind: str, amount: int, largest: int, generator: torch.Generator) -> Table:
    """So many islands of 2 to `largest` boxes; some boxes are background, and some of those the ground."""
    parts, first, second, n = [], [], [], 0
    for _ in range(amount):
        parts.append(island(kind, int(torch.randint(2, largest + 1, (1,), generator=generator)), generator))
        a, b = torch.triu_indices(len(parts[-1]), len(parts[-1]), offset=1)
        first.append(a + n)
        second.append(b + n)
        n += len(parts[-1])
    boxes, pairs = concatenate(parts), (torch.cat(first), torch.cat(second))
    role = torch.rand(n, generator=generator)
    height = torch.zeros(n, dtype=torch.float64)
    return Table(boxes, pairs, separation(boxes, *pairs), height, role > 0.1, role < 0.02)


def island(kind: str, n: int, generator: torch.Generator) -> Boxes:
    """N boxes on the ground and on each other."""

    def uniform(*shape: int) -> Tensor:
        return torch.rand(*shape, dtype=torch.float64, generator=generator)

    spread = max(1.0, math.sqrt(n / 4))
    if kind == "any":
        boxes = _any(uniform, n, spread)
    else:
        boxes = _on_grid(uniform, n, spread)
        if kind == "in contact, turned":
            boxes = boxes.rotated(_turn(1, 2 * math.pi * uniform(1))[0])
        if kind == "nearly in contact":
            size = 10.0 ** (
                -17 + 6 * uniform(1)
            )  # from far below rounding to just above what counts as equal
            boxes = _shaken(boxes, size, uniform)
    axes = torch.randperm(3, generator=generator)
    if uniform(1) < 0.3:
        boxes = Boxes(boxes.center, boxes.rotation[..., axes].contiguous(), boxes.half_extent[:, axes])
    if uniform(1) < 0.3:  # far from the camera more counts as contact
        boxes = Boxes(boxes.center + 2 * uniform(3) * _ALONG_GROUND, boxes.rotation, boxes.half_extent)
    return boxes


def _any(uniform, n, spread):
    half = 0.02 + 0.1 * uniform(n, 3)
    center = torch.tensor([0.4 * spread, 0.3, 0.3 * spread]) * (uniform(n, 3) - torch.tensor([0.5, 0.0, 0.5]))
    center[:, 1] = torch.where(uniform(n) < 0.5, half[:, 1], center[:, 1])
    leaning = 1.5 * (uniform(n) - 0.5) * (uniform(n) < 0.3) + 0.02 * (uniform(n) - 0.5)
    return Boxes(center, _turn(1, 2 * math.pi * uniform(n)) @ _turn(2, leaning), half)


def _on_grid(uniform, n, spread):
    half = _CELL * (1 + 4 * uniform(n, 3)).floor()
    place = torch.tensor([6 * spread, 0.0, 4 * spread]) * (uniform(n, 3) - 0.5)
    center = _CELL * place.round()
    center[:, 1] = 2 * _CELL * (5 * uniform(n)).floor() + half[:, 1]
    return Boxes(center, torch.eye(3, dtype=torch.float64).repeat(n, 1, 1), half)


def _shaken(boxes, size, uniform):
    n = len(boxes)
    turn = _turn(1, size * (uniform(n) - 0.5)) @ _turn(0, size * (uniform(n) - 0.5))
    center = boxes.center + size * (uniform(n, 3) - 0.5)
    return Boxes(center, boxes.rotation @ turn, boxes.half_extent + size * (uniform(n, 3) - 0.5))


def _turn(axis: int, angle: Tensor) -> Tensor:
    """Rotations about one axis of the world, (n, 3, 3)."""
    turn = torch.eye(3, dtype=torch.float64).repeat(len(angle), 1, 1)
    a, b = (axis + 1) % 3, (axis + 2) % 3
    turn[:, a, a] = turn[:, b, b] = torch.cos(angle)
    turn[:, b, a], turn[:, a, b] = torch.sin(angle), -torch.sin(angle)
    return turn
