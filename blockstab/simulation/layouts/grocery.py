"""The preset `grocery`: cartons, cans and bottles in rows and stacks, flush as on a shelf (the paper's GD)."""

from __future__ import annotations

import torch

from blockstab.simulation.layouts.draws import chance, choice, uniform, whole
from blockstab.simulation.layouts.placing import lifted, shifted, stand
from blockstab.simulation.layouts.products import draw_product
from blockstab.simulation.physics.solids import Pile, concatenate

_GOAL, _MOST = (6, 15), 18
_WIDEST = (0.35, 0.75)  # metres, of a row
_GAP = (0.0, 0.001)  # metres between neighbours

# How many of a product stand side by side, and how many one on another.
_FACINGS = {
    "cereal": ((2, 3), (1, 1)),
    "crackers": ((2, 3), (1, 1)),
    "tea": ((1, 2), (2, 3)),
    "biscuits": ((1, 2), (2, 4)),
    "juice": ((2, 4), (1, 1)),
    "rice": ((2, 3), (1, 2)),
    "soup": ((2, 4), (1, 2)),
    "tuna": ((1, 3), (2, 3)),
    "beans": ((2, 3), (1, 2)),
    "water": ((2, 3), (1, 1)),
    "sauce": ((2, 3), (1, 1)),
}
_ROUND_TOPS = ("water", "sauce")
_LAID_ON_TOP = ("tea", "biscuits")


def arrange_grocery(generator: torch.Generator) -> Pile:
    """Six to eighteen products in one row, or one behind another, fronts aligned and towards +z.

    Those of one product are of one size and have one `Solid.product` number; neighbours touch or are at most
    a millimetre apart.

    Returns:
        A pile in the table frame (right-handed, +y up, metres; the table is the plane y = 0), where a hand
        lets go of it.
    """
    enough, widest = whole(generator, *_GOAL), uniform(generator, *_WIDEST)
    facings: list[Pile] = []
    while (count := sum(map(len, facings))) < enough:
        facings.append(_facing(generator, len(facings) + 1, _MOST - count))
    rows, z = [], 0.0
    for row in _rows(facings, widest):
        rows.append(shifted(_in_line(generator, row), z=z))
        z -= max(_size(facing)[2] for facing in row) + uniform(generator, *_GAP)
    return _in_the_middle(concatenate(rows))


def _rows(facings: list[Pile], widest: float) -> list[list[Pile]]:
    """The facings in rows from front to back, the lowest in front so that the others look over them."""
    rows: list[list[Pile]] = [[]]
    for facing in sorted(facings, key=lambda each: _size(each)[1]):
        if rows[-1] and sum(_size(each)[0] for each in [*rows[-1], facing]) > widest:
            rows.append([])
        rows[-1].append(facing)
    return rows


def _in_line(generator: torch.Generator, facings: list[Pile]) -> Pile:
    """The facings side by side in any order, from x = 0 to the right."""
    parts, x = [], 0.0
    for k in torch.randperm(len(facings), generator=generator).tolist():
        parts.append(shifted(facings[k], x=x))
        x += _size(facings[k])[0] + uniform(generator, *_GAP)
    return concatenate(parts)


def _facing(generator: torch.Generator, number: int, most: int) -> Pile:
    """At most `most` things of one product, from x = 0 to the right and from z = 0 to the back."""
    name = choice(generator, tuple(_FACINGS))
    columns, layers = (whole(generator, *each) for each in _FACINGS[name])
    columns = min(columns, most)
    layers = min(layers, most // columns)
    solid = draw_product(generator, name, number)
    wide, tall, deep = (2.0 * solid.half_extent).tolist()
    parts, x = [], 0.0
    for _ in range(columns):
        parts += [stand(solid, x + wide / 2, -deep / 2, layer * tall) for layer in range(layers)]
        x += wide + uniform(generator, *_GAP)
    if columns * layers < most and name not in _ROUND_TOPS and chance(generator, 0.6):
        parts += _laid_on_top(generator, x - _GAP[1], deep, layers * tall)
    return lifted(concatenate(parts))


def _laid_on_top(generator: torch.Generator, wide: float, deep: float, on: float) -> list[Pile]:
    """A flat carton in the middle of a facing, its front in line; none where it is too wide or too deep."""
    solid = draw_product(generator, choice(generator, _LAID_ON_TOP))
    half = solid.half_extent.tolist()
    fits = 2.0 * half[0] <= wide and half[2] < 0.8 * deep
    return [stand(solid, wide / 2, -half[2], on)] if fits else []


def _size(pile: Pile) -> list[float]:
    """Width, height and depth of a pile, metres."""
    corners = pile.boxes().corners().flatten(0, 1)
    size: list[float] = (corners.amax(dim=0) - corners.amin(dim=0)).tolist()
    return size


def _in_the_middle(pile: Pile) -> Pile:
    corners = pile.boxes().corners().flatten(0, 1)
    x, _, z = (-(corners.amax(dim=0) + corners.amin(dim=0)) / 2).tolist()
    return shifted(pile, x=x, z=z)
