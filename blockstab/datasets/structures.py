"""Small structures of wooden blocks: towers, bridges, overhangs, rows, leaning pairs.

Each stands on the plane y = 0 of its own frame (+y up, metres), near the origin. Block sides are 6 to 24 cm,
and whatever rests on something starts `LIFT` above it.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

import torch
from torch import Tensor

from blockstab.boxes.box import Boxes

LIFT = 0.001  # metres; so low a drop does not upset a structure


class Block(NamedTuple):
    """A block of a structure: its centre, metres, and its half extents before it is turned."""

    x: float
    y: float
    z: float
    half: tuple[float, float, float]
    yaw: float = 0.0  # about +y
    lean: float = 0.0  # about the block's own z, before the yaw


def as_boxes(blocks: list[Block]) -> Boxes:
    """The blocks of a structure as boxes, in its frame."""
    values = torch.tensor([[b.x, b.y, b.z, *b.half, b.yaw, b.lean] for b in blocks], dtype=torch.float64)
    lean = torch.eye(3, dtype=torch.float64).repeat(len(blocks), 1, 1)
    c, s = values[:, 7].cos(), values[:, 7].sin()
    lean[:, 0, 0], lean[:, 0, 1], lean[:, 1, 0], lean[:, 1, 1] = c, -s, s, c
    return Boxes(values[:, :3], about_up(values[:, 6]) @ lean, values[:, 3:6])


def about_up(yaw: Tensor) -> Tensor:
    """Rotations (..., 3, 3) by `yaw` (...) radians about +y."""
    turn = torch.eye(3, dtype=torch.float64).repeat(*yaw.shape, 1, 1)
    turn[..., 0, 0], turn[..., 0, 2] = yaw.cos(), yaw.sin()
    turn[..., 2, 0], turn[..., 2, 2] = -yaw.sin(), yaw.cos()
    return turn


def _tower(generator: torch.Generator) -> list[Block]:
    """Two to four layers, each a little off the one below."""
    blocks: list[Block] = []
    top, reach, x, z = 0.0, _uniform(generator, 0.06, 0.1), 0.0, 0.0
    for _ in range(_whole(generator, 2, 4)):
        half = tuple(_uniform(generator, 0.85, 1.2) * reach for _ in range(2))
        tall = _uniform(generator, 0.03, 0.07)
        blocks.append(
            Block(x, top + LIFT + tall, z, (half[0], tall, half[1]), _uniform(generator, -0.4, 0.4))
        )
        x, z = x + _uniform(generator, -0.35, 0.35) * reach, z + _uniform(generator, -0.35, 0.35) * reach
        top += LIFT + 2 * tall
        reach = max(0.036, reach * _uniform(generator, 0.6, 1.0))
    return blocks


def _bridge(generator: torch.Generator) -> list[Block]:
    """A beam on two equal pillars, at times with a block on it."""
    span, tall, wide = (_uniform(generator, *r) for r in ((0.09, 0.12), (0.03, 0.1), (0.03, 0.045)))
    deep, thick = _uniform(generator, 0.03, 0.06), _uniform(generator, 0.03, 0.04)
    apart = _uniform(generator, wide + 0.002, span - 0.4 * wide)
    beam = LIFT + 2 * tall + LIFT + thick
    blocks = [Block(side * apart, LIFT + tall, 0.0, (wide, tall, deep)) for side in (-1, 1)]
    blocks.append(Block(0.0, beam, 0.0, (span, thick, deep), _uniform(generator, -0.15, 0.15)))
    if _chance(generator, 0.5):
        half = (_uniform(generator, 0.03, 0.05), _uniform(generator, 0.03, 0.05), 0.035)
        x = _uniform(generator, -0.5, 0.5) * span
        blocks.append(Block(x, beam + thick + LIFT + half[1], 0.0, half, _uniform(generator, -0.8, 0.8)))
    return blocks


def _overhang(generator: torch.Generator) -> list[Block]:
    """A long block whose end hangs out; at times so far that only a counterweight holds it."""
    base = (_uniform(generator, 0.05, 0.08), _uniform(generator, 0.03, 0.08), _uniform(generator, 0.04, 0.08))
    beam = (_uniform(generator, 0.1, 0.12), _uniform(generator, 0.03, 0.035), _uniform(generator, 0.03, 0.05))
    weighted = _chance(generator, 0.4)
    out = base[0] + (_uniform(generator, 0.01, 0.03) if weighted else -_uniform(generator, 0.01, 0.03))
    top = LIFT + 2 * base[1]
    blocks = [Block(0.0, LIFT + base[1], 0.0, base), Block(out, top + LIFT + beam[1], 0.0, beam)]
    if weighted:
        half = (0.035, _uniform(generator, 0.045, 0.08), beam[2])
        blocks.append(Block(out - beam[0] + half[0], top + 2 * LIFT + 2 * beam[1] + half[1], 0.0, half))
    return blocks


def _pedestal(generator: torch.Generator) -> list[Block]:
    """Two small blocks on a wide one."""
    base = (_uniform(generator, 0.1, 0.12), _uniform(generator, 0.03, 0.06), _uniform(generator, 0.05, 0.1))
    blocks = [Block(0.0, LIFT + base[1], 0.0, base)]
    for side in (-1, 1):
        half = (
            _uniform(generator, 0.03, 0.04),
            _uniform(generator, 0.03, 0.08),
            _uniform(generator, 0.03, 0.045),
        )
        x, yaw = side * _uniform(generator, 0.056, 0.07), _uniform(generator, -0.1, 0.1)
        blocks.append(Block(x, 2 * base[1] + 2 * LIFT + half[1], 0.0, half, yaw))
    return blocks


def _row(generator: torch.Generator) -> list[Block]:
    """Two blocks almost touching, at times as high as each other and with a third across the joint."""
    gap = _uniform(generator, 0.0005, 0.006)
    level = _chance(generator, 0.6)
    tall = _uniform(generator, 0.03, 0.08)
    blocks = []
    for side in (-1, 1):
        wide, deep = _uniform(generator, 0.03, 0.07), _uniform(generator, 0.03, 0.08)
        high = tall if level else _uniform(generator, 0.03, 0.1)
        z = _uniform(generator, -0.02, 0.02)
        blocks.append(Block(side * (wide + gap / 2), LIFT + high, z, (wide, high, deep)))
    if level:
        half = (
            _uniform(generator, 0.04, 0.07),
            _uniform(generator, 0.03, 0.05),
            _uniform(generator, 0.03, 0.05),
        )
        blocks.append(Block(0.0, 2 * tall + 2 * LIFT + half[1], 0.0, half, _uniform(generator, -0.3, 0.3)))
    return blocks


def _leaning_pair(generator: torch.Generator) -> list[Block]:
    """A plank with one end on the table and its lower face on the edge of a block."""
    plank = (_uniform(generator, 0.11, 0.12), 0.03, _uniform(generator, 0.04, 0.06))
    slope = _uniform(generator, 0.4, 0.75)
    along = _uniform(generator, 1.3, 1.7) * plank[0]  # from the plank's lower end to the edge
    half = (_uniform(generator, 0.05, 0.09), max(0.03, 0.5 * along * math.sin(slope)), plank[2])
    c, s = math.cos(slope), math.sin(slope)
    # The lower face passes through the origin and through the block's upper edge.
    x, y = plank[0] * c - plank[1] * s, plank[0] * s + plank[1] * c
    edge = 2 * half[1] / math.tan(slope)
    return [
        Block(edge + half[0], LIFT + half[1], 0.0, half),
        Block(x, y + 2.5 * LIFT, 0.0, plank, lean=slope),
    ]


def _single(generator: torch.Generator) -> list[Block]:
    """One block by itself."""
    half = tuple(_uniform(generator, 0.03, 0.09) for _ in range(3))
    return [Block(0.0, LIFT + half[1], 0.0, (half[0], half[1], half[2]))]


STRUCTURES: tuple[Callable[[torch.Generator], list[Block]], ...] = (
    _tower,
    _bridge,
    _bridge,
    _overhang,
    _pedestal,
    _row,
    _leaning_pair,
    _single,
)


def _uniform(generator: torch.Generator, low: float, high: float) -> float:
    return low + (high - low) * float(torch.rand((), generator=generator, dtype=torch.float64))


def _whole(generator: torch.Generator, low: int, high: int) -> int:
    return int(torch.randint(low, high + 1, (), generator=generator))


def _chance(generator: torch.Generator, probability: float) -> bool:
    return _uniform(generator, 0.0, 1.0) < probability
