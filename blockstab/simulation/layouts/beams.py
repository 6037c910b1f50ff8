"""Wooden beams across pillars, and beams that reach out over an edge, each structure in exact contact."""

from __future__ import annotations

import torch

from blockstab.simulation.layouts.draws import chance, twist, uniform, whole
from blockstab.simulation.layouts.placing import height, stand
from blockstab.simulation.physics.solids import Pile, Solid, box, concatenate

Range = tuple[float, float]


def block(generator: torch.Generator, *half_extent: Range, style: str = "block") -> Solid:
    """A block whose three half extents lie in these ranges, metres."""
    return box([uniform(generator, *each) for each in half_extent], style)


def plank(generator: torch.Generator, long: Range, deep: Range) -> Solid:
    """A plank 1.5 to 3 cm thick whose other half extents lie in these ranges, metres."""
    return block(generator, long, (0.0075, 0.015), deep, style="plank")


def bridge(generator: torch.Generator) -> Pile:
    """A beam on two equal pillars, at times with a block on it."""
    beam = _beam(generator, (0.08, 0.12))
    parts = _spanned(generator, beam, on=0.0)
    if chance(generator, 0.6):
        rider = block(generator, (0.025, 0.05), (0.02, 0.06), (0.02, 0.04))
        x = 0.5 * float(beam.half_extent[0]) * twist(generator, 1.0)
        parts.append(stand(rider, x, 0.0, _top(parts), twist(generator, 0.8)))
    return concatenate(parts)


def two_storey_bridge(generator: torch.Generator) -> Pile:
    """A bridge on the beam of a bridge."""
    parts = _spanned(generator, _beam(generator, (0.1, 0.12)), on=0.0)
    parts += _spanned(generator, _beam(generator, (0.075, 0.1)), on=_top(parts))
    return concatenate(parts)


def overhang(generator: torch.Generator) -> Pile:
    """A long block whose middle is just inside the edge of the one below, so that it nearly tips."""
    base = block(generator, (0.04, 0.08), (0.02, 0.08), (0.03, 0.08))
    beam = _beam(generator, (0.09, 0.12))
    wide = float(base.half_extent[0])
    x = wide - uniform(generator, 0.1, 0.5) * wide
    return concatenate([stand(base), stand(beam, x, 0.0, height(base), twist(generator, 0.2))])


def counterweight(generator: torch.Generator) -> Pile:
    """A beam that reaches out so far that only the block on its inner end holds it."""
    base = block(generator, (0.05, 0.08), (0.02, 0.08), (0.04, 0.08))
    beam = _beam(generator, (0.1, 0.12))
    wide, long, thick, deep = float(base.half_extent[0]), *beam.half_extent.tolist()
    out = wide + uniform(generator, 0.08, 0.25) * wide
    half = (uniform(generator, 0.03, 0.04), max(0.04, 1.2 * thick), max(0.03, deep))
    weight = block(generator, (half[0], half[0]), (half[1], 0.09), (half[2], half[2]))
    on = height(base) + height(beam)
    x = out - long + half[0]
    return concatenate([stand(base), stand(beam, out, 0.0, height(base)), stand(weight, x, 0.0, on)])


def corbel(generator: torch.Generator) -> Pile:
    """Equal blocks, each further out than the one below, near the limit of what holds (1/2, 1/4, 1/6 ...)."""
    brick = block(generator, (0.06, 0.11), (0.02, 0.035), (0.03, 0.05))
    layers = whole(generator, 3, 4)
    share = uniform(generator, 0.5, 0.85)
    x, parts = 0.0, []
    for layer in range(layers):
        parts.append(stand(brick, x, 0.0, layer * height(brick)))
        x += share * float(brick.half_extent[0]) / max(1, layers - 1 - layer)
    return concatenate(parts)


def _beam(generator: torch.Generator, long: Range) -> Solid:
    if chance(generator, 0.5):
        return plank(generator, long, (0.03, 0.05))
    return block(generator, long, (0.02, 0.035), (0.025, 0.05))


def _spanned(generator: torch.Generator, beam: Solid, on: float) -> list[Pile]:
    """Two pillars that stand at height `on`, and the beam across them."""
    span, deep = float(beam.half_extent[0]), float(beam.half_extent[2])
    pillar = block(generator, (0.02, 0.03), (0.025, 0.07), (0.02, min(deep, 0.035)))
    wide = float(pillar.half_extent[0])
    apart = uniform(generator, 0.55 * span, span - 0.6 * wide)
    pillars = [stand(pillar, side * apart, 0.0, on) for side in (-1, 1)]
    return [*pillars, stand(beam, 0.0, 0.0, on + height(pillar), twist(generator, 0.1))]


def _top(parts: list[Pile]) -> float:
    return max(float(part.boxes().corners()[..., 1].max()) for part in parts)
