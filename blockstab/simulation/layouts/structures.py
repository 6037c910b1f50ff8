"""Structures of wooden blocks, each in exact contact: towers, walls, stairs, rows, leaning planks, and spans.

Block sides are 4 to 24 cm; planks are from 1.5 cm thick.
"""

from __future__ import annotations

import math

import torch

from blockstab.simulation.layouts.beams import (
    block,
    bridge,
    corbel,
    counterweight,
    overhang,
    plank,
    two_storey_bridge,
)
from blockstab.simulation.layouts.draws import twist, uniform, whole
from blockstab.simulation.layouts.placing import Structure, height, leaning, stand
from blockstab.simulation.physics.solids import Pile, box, concatenate


def tower(generator: torch.Generator) -> Pile:
    """Two to five layers, each a little off the one below."""
    parts: list[Pile] = []
    on, x, z, reach = 0.0, 0.0, 0.0, uniform(generator, 0.05, 0.1)
    for _ in range(whole(generator, 2, 5)):
        side = (0.85 * reach, 1.2 * reach)
        layer = block(generator, side, (0.02, 0.055), side)
        parts.append(stand(layer, x, z, on, twist(generator, 0.4)))
        x, z = x + 0.35 * reach * twist(generator, 1.0), z + 0.35 * reach * twist(generator, 1.0)
        on, reach = on + height(layer), max(0.024, reach * uniform(generator, 0.65, 1.0))
    return concatenate(parts)


def pedestal(generator: torch.Generator) -> Pile:
    """Two towers of one or two blocks on a wide one."""
    base = block(generator, (0.1, 0.12), (0.02, 0.06), (0.05, 0.1))
    parts = [stand(base)]
    for side in (-1, 1):
        on, x = height(base), side * uniform(generator, 0.05, 0.065)
        for reach in (0.04, 0.03)[: whole(generator, 1, 2)]:
            part = block(generator, (0.75 * reach, reach), (0.02, 0.05), (0.75 * reach, reach))
            parts.append(stand(part, x, 0.0, on, twist(generator, 0.1)))
            on += height(part)
    return concatenate(parts)


def row(generator: torch.Generator) -> Pile:
    """Two or three blocks of equal height, almost touching, with one across each joint."""
    wide, tall, deep = (uniform(generator, *each) for each in ((0.035, 0.06), (0.025, 0.08), (0.03, 0.06)))
    pitch = 2 * wide + uniform(generator, 0.0005, 0.006)
    count = whole(generator, 2, 3)
    standing = box([wide, tall, deep])
    first = -0.5 * (count - 1) * pitch
    parts = [stand(standing, first + k * pitch, uniform(generator, -0.01, 0.01)) for k in range(count)]
    for joint in range(count - 1):
        across = block(generator, (0.6 * wide, 0.9 * wide), (0.02, 0.05), (0.025, 0.045))
        parts.append(stand(across, first + (joint + 0.5) * pitch, 0.0, 2 * tall, twist(generator, 0.1)))
    return concatenate(parts)


def wall(generator: torch.Generator) -> Pile:
    """Bricks in two or three courses, each brick across a joint of the course below."""
    brick = block(generator, (0.04, 0.055), (0.02, 0.03), (0.025, 0.035))
    pitch = 2 * float(brick.half_extent[0]) + uniform(generator, 0.0, 0.004)
    longest, courses = whole(generator, 2, 3), whole(generator, 2, 3)
    return concatenate(
        [
            stand(brick, (k - 0.5 * (longest - 1 - course)) * pitch, 0.0, course * height(brick))
            for course in range(min(longest, courses))
            for k in range(longest - course)
        ]
    )


def steps(generator: torch.Generator) -> Pile:
    """A staircase: planks one on another, each shorter than the one below, their backs in line."""
    count, deep = whole(generator, 2, 4), uniform(generator, 0.03, 0.06)
    long, thick = uniform(generator, 0.1, 0.12), uniform(generator, 0.02, 0.035)
    tread = uniform(generator, 0.15, 0.25) * long
    parts = []
    for step in range(count):
        half = long - step * tread
        parts.append(stand(box([half, thick, deep]), -step * tread, 0.0, 2 * thick * step))
    return concatenate(parts)


def leaning_plank(generator: torch.Generator) -> Pile:
    """A plank with one end on the table and its lower face on the upper edge of one block or of a stack of two."""
    wide, deep = uniform(generator, 0.04, 0.07), uniform(generator, 0.03, 0.05)
    tall = [uniform(generator, 0.02, 0.036) for _ in range(whole(generator, 1, 2))]
    edge = 2 * sum(tall)
    board = plank(generator, (max(0.09, 0.8 * edge), 0.12), (0.025, deep))
    long = float(board.half_extent[0])
    slope = math.asin(min(0.75, edge / (uniform(generator, 1.2, 1.7) * long)))
    return concatenate([*_stacked(wide, tall, deep), leaning(board, slope, edge, -wide)])


def _stacked(wide: float, tall: list[float], deep: float) -> list[Pile]:
    levels = [2 * sum(tall[:k]) for k in range(len(tall))]
    return [stand(box([wide, t, deep]), 0.0, 0.0, on) for t, on in zip(tall, levels, strict=True)]


def single(generator: torch.Generator) -> Pile:
    """One block by itself."""
    return stand(block(generator, *[(0.02, 0.08)] * 3))


STRUCTURES: tuple[Structure, ...] = (
    tower,
    bridge,
    two_storey_bridge,
    overhang,
    counterweight,
    corbel,
    pedestal,
    row,
    wall,
    steps,
    leaning_plank,
    single,
)
