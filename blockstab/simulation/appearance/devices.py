"""Looks of screens, laptops, keyboards, mice, phones, pens and tools."""

from __future__ import annotations

from collections.abc import Sequence

from torch import Generator

from blockstab.simulation.appearance.covers import Palette
from blockstab.simulation.appearance.finish import Finish, Grain, Look
from blockstab.simulation.appearance.lettering import Color, Place, Sheet, shaded
from blockstab.simulation.appearance.meshes import Patch
from blockstab.simulation.layouts.draws import chance, choice, uniform
from blockstab.simulation.physics.solids import Solid

STYLES = ("screen", "laptop", "keyboard", "mouse", "phone", "pen", "tool")
_CASES: tuple[Color, ...] = (
    (24, 24, 26),
    (36, 36, 40),
    (52, 52, 56),
    (150, 150, 154),
    (186, 186, 188),
    (222, 220, 216),
)
_GLASS: Color = (14, 14, 17)
_STEEL: Color = (170, 170, 172)
_KEY = 0.018  # metres from key to key


def device(solid: Solid, patches: Sequence[Patch], colors: Palette, generator: Generator) -> Look:
    """Make a device up: a dark or silver case, black glass, rows of keys; pens and tools come in colours."""
    case = shaded(choice(generator, _CASES), uniform(generator, 0.8, 1.2))
    if solid.style in ("pen", "tool"):
        case = choice(generator, (colors.ground, _STEEL, _CASES[0]))
    finish = Finish(uniform(generator, 0.1, 0.6), uniform(generator, 10.0, 80.0))
    glass = Finish(uniform(generator, 0.4, 0.9), 120.0)
    sheets, finishes = [], []
    for patch in patches:
        glassy = _is_glass(solid, patch)
        sheets.append(_sheet(solid, patch, _GLASS if glassy else case, colors, generator))
        finishes.append(glass if glassy else finish)
    return Look(case, Grain(mottle=0.03, spot=0.03), tuple(sheets), tuple(finishes))


def _is_glass(solid: Solid, patch: Patch) -> bool:
    match solid.style:
        case "screen":
            return patch.form == "box" and patch.face == 4 and patch.height > 0.1
        case "laptop":
            return patch.form == "hull"
        case "phone":
            return patch.face == 2
        case _:
            return False


def _sheet(solid: Solid, patch: Patch, ground: Color, colors: Palette, generator: Generator) -> Sheet:
    sheet = Sheet(patch.width, patch.height, ground)
    above = patch.form == "box" and patch.face == 2
    if solid.style == "keyboard" and above:
        _keys(sheet, Place(0.02, 0.06, 0.96, 0.88), shaded(ground, uniform(generator, 0.6, 1.4)))
    elif solid.style == "laptop" and above:
        _keys(sheet, Place(0.08, 0.08, 0.84, 0.5), _CASES[0])
        sheet.block(Place(0.36, 0.66, 0.28, 0.28), shaded(ground, 0.85))
    elif solid.style == "pen" and patch.face == 0:
        sheet.block(Place(0.0, 0.0, 1.0, uniform(generator, 0.1, 0.4)), colors.accent)
    elif solid.style == "tool" and above and chance(generator, 0.6):
        sheet.block(Place(0.0, 0.0, 1.0, uniform(generator, 0.3, 0.5)), colors.accent)
    return sheet


def _keys(sheet: Sheet, place: Place, color: Color) -> None:
    width, height = sheet.extent
    columns, rows = max(1, round(place.width * width / _KEY)), max(1, round(place.height * height / _KEY))
    wide, tall = place.width / columns, place.height / rows
    for row in range(rows):
        for column in range(columns):
            left, top = place.left + column * wide, place.top + row * tall
            sheet.block(Place(left + 0.1 * wide, top + 0.1 * tall, 0.8 * wide, 0.8 * tall), color)
