"""Boxes put down exactly in contact that may or may not stand, near tipping on either side."""

from __future__ import annotations

import math
from collections.abc import Callable

import torch

from blockstab.simulation.layouts.beams import block, plank
from blockstab.simulation.layouts.draws import chance, choice, twist, uniform, whole
from blockstab.simulation.layouts.placing import beside, height, leaning, stand
from blockstab.simulation.layouts.structures import STRUCTURES
from blockstab.simulation.physics.solids import Pile, box, concatenate

_NEAR, _FAR = 0.05, 0.3  # of the supporting width: how far inside or outside its edge the weight acts
_FEWEST, _MOST = 3, 10


def placed_unsettled(generator: torch.Generator) -> Pile:
    """Three to ten boxes, in exact contact and not settled; in about every second pile something tips.

    One or two structures whose weight acts 5 to 30 % of the supporting width inside or outside its edge
    stand beside some that hold.

    Returns:
        A pile in the table frame (right-handed, +y up, metres; the table is the plane y = 0).
    """
    doubtful = [choice(generator, DOUBTFUL) for _ in range(whole(generator, 1, 2))]
    tips = 1.0 - 0.5 ** (1.0 / len(doubtful))
    structures = [structure(generator, _margin(generator, tips)) for structure in doubtful]
    sure = [choice(generator, STRUCTURES)(generator) for _ in range(3)]
    while sum(map(len, structures)) < _FEWEST or (sure and chance(generator, 0.5)):
        structures.append(sure.pop())
    parts: list[Pile] = []
    for structure in structures:
        placed = beside(generator, structure, parts)
        if placed is not None and sum(map(len, [*parts, placed])) <= _MOST:
            parts.append(placed)
    return concatenate(parts)


def _margin(generator: torch.Generator, tips: float) -> float:
    """Distance of the weight inside the edge, as a share of the supporting width; negative where it tips."""
    side = -1.0 if chance(generator, tips) else 1.0
    return side * uniform(generator, _NEAR, _FAR)


def _overhang(generator: torch.Generator, margin: float) -> Pile:
    """A block that hangs out over an edge of the block below, at times with another on it."""
    base = block(generator, (0.04, 0.08), (0.02, 0.08), (0.03, 0.06))
    beam = block(generator, (0.07, 0.12), (0.02, 0.05), (0.025, 0.05))
    wide = float(base.half_extent[0])
    x, z = (1.0 - 2.0 * margin) * wide, 0.3 * twist(generator, float(base.half_extent[2]))
    parts = [stand(base), stand(beam, x, z, height(base))]
    if chance(generator, 0.5):
        rider = block(generator, *[(0.02, 0.04)] * 3)
        parts.append(stand(rider, x, z, height(base) + height(beam), twist(generator, 0.8)))
    return concatenate(parts)


def _corbel(generator: torch.Generator, margin: float) -> Pile:
    """Equal blocks in even steps outward, all but the lowest of which act near its edge."""
    brick = block(generator, (0.06, 0.11), (0.02, 0.035), (0.03, 0.05))
    above = whole(generator, 2, 4)
    step = 2.0 * (1.0 - 2.0 * margin) * float(brick.half_extent[0]) / (above + 1)
    return concatenate([stand(brick, k * step, 0.0, k * height(brick)) for k in range(above + 1)])


def _missing_pillar(generator: torch.Generator, margin: float) -> Pile:
    """A beam on one pillar near its middle; under its other end the pillar is too short or is not there."""
    beam = block(generator, (0.09, 0.12), (0.02, 0.03), (0.025, 0.05))
    wide, tall, deep = (uniform(generator, *each) for each in ((0.02, 0.03), (0.05, 0.08), (0.025, 0.05)))
    pillar, short = box([wide, tall, deep]), box([wide, 0.4 * tall, deep])
    parts = [stand(pillar, (2.0 * margin - 1.0) * wide), stand(beam, 0.0, 0.0, height(pillar))]
    if chance(generator, 0.7):
        parts.append(stand(short, float(beam.half_extent[0]) - wide))
    return concatenate(parts)


def _shifted_pillars(generator: torch.Generator, margin: float) -> Pile:
    """A beam on two pillars of which the nearer to its middle is at the edge of what holds."""
    beam = block(generator, (0.1, 0.12), (0.02, 0.03), (0.03, 0.05))
    pillar = block(generator, (0.015, 0.02), (0.025, 0.07), (0.02, 0.03))
    wide = float(pillar.half_extent[0])
    apart = uniform(generator, 2.2, 3.0) * wide
    near = margin * (apart + 2.0 * wide) - wide
    parts = [stand(pillar, x) for x in (near, near - apart)]
    return concatenate([*parts, stand(beam, 0.0, 0.0, height(pillar), twist(generator, 0.05))])


def _counterweight(generator: torch.Generator, margin: float) -> Pile:
    """A beam far out over an edge, and on its inner end a block that may or may not be heavy enough."""
    base = block(generator, (0.04, 0.06), (0.02, 0.08), (0.04, 0.06))
    beam = block(generator, (0.1, 0.12), (0.02, 0.03), (0.025, 0.04))
    weight = block(generator, (0.02, 0.03), (0.02, 0.06), (0.02, 0.04))
    volumes = torch.stack([beam.half_extent.prod(), weight.half_extent.prod()])
    share = float(volumes[1] / volumes.sum())
    inward = float(beam.half_extent[0] - weight.half_extent[0])
    x = (1.0 - 2.0 * margin) * float(base.half_extent[0]) + share * inward
    top = height(base) + height(beam)
    return concatenate([stand(base), stand(beam, x, 0.0, height(base)), stand(weight, x - inward, 0.0, top)])


def _leaning_too_far(generator: torch.Generator, margin: float) -> Pile:
    """A plank over the edge of a block, its middle near that edge."""
    board = plank(generator, (0.1, 0.12), (0.025, 0.04))
    long, thick = board.half_extent[:2].tolist()
    slope = uniform(generator, 0.4, 0.55)  # steeper planks slide rather than tip
    # The middle is over a point of the lower face that is this much nearer to the foot.
    along = (long - thick * math.tan(slope)) / (1.0 - margin)
    edge = along * math.sin(slope)
    support = box([uniform(generator, 0.03, 0.06), edge / 2, uniform(generator, 0.03, 0.05)])
    wide = float(support.half_extent[0])
    return concatenate([stand(support), leaning(board, slope, edge, -wide)])


DOUBTFUL: tuple[Callable[[torch.Generator, float], Pile], ...] = (
    _overhang,
    _corbel,
    _missing_pillar,
    _shifted_pillars,
    _counterweight,
    _leaning_too_far,
)
