"""Looks of tables, floors, walls and cabinets."""

from __future__ import annotations

from collections.abc import Sequence

from PIL import Image
from torch import Generator

from blockstab.simulation.appearance.finish import Finish, Grain, Look
from blockstab.simulation.appearance.lettering import Color, Place, Sheet, shaded
from blockstab.simulation.appearance.meshes import Patch
from blockstab.simulation.layouts.draws import chance, choice, uniform, whole
from blockstab.simulation.physics.solids import Solid

_FINE, _COARSE = 0.001, 0.002  # metres from dot to dot
_PAPER: Color = (214, 212, 204)
_LAMINATES: tuple[Color, ...] = (
    *((196, 170, 148), (206, 186, 166), (176, 150, 126), (150, 122, 98), (94, 72, 58), (120, 98, 80)),
)
_TOPS: tuple[Color, ...] = ((190, 186, 178), (142, 142, 144), (178, 168, 148), (74, 72, 72), (206, 204, 200))
_CLOTHS: tuple[Color, ...] = ((112, 66, 62), (84, 98, 122), (178, 168, 148), (92, 104, 84), (60, 60, 70))
_FLOORS: tuple[Color, ...] = ((140, 104, 70), (94, 92, 96), (154, 146, 132), (62, 58, 58), (116, 84, 58))
_WALLS: tuple[Color, ...] = (
    (206, 202, 194),
    (198, 190, 168),
    (176, 188, 184),
    (160, 158, 160),
    (188, 168, 150),
)
_SHELVES: tuple[Color, ...] = ((190, 190, 188), (120, 120, 124), (54, 46, 42), (34, 34, 38), (158, 122, 88))


def furnished(solid: Solid, patches: Sequence[Patch], generator: Generator) -> Look:
    """Make a piece of the room up after its style: table, floor, wall or shelf."""
    if solid.style == "table":
        return _table(patches, generator)
    tones = {"floor": _FLOORS, "wall": _WALLS, "shelf": _SHELVES}[solid.style]
    plain = shaded(choice(generator, tones), uniform(generator, 0.85, 1.1))
    grain = Grain(mottle=uniform(generator, 0.04, 0.12), spot=uniform(generator, 0.05, 0.3))
    finish = Finish(uniform(generator, 0.0, 0.15), 8.0)
    sheets = [Sheet(0.01, 0.01, plain)] * len(patches)
    if solid.style == "floor":
        grain = grain._replace(speckle=uniform(generator, -0.4, 0.4))
        sheets[2], finish = floor(plain, generator), Finish(uniform(generator, 0.05, 0.4), 30.0)
    elif solid.style == "wall":
        grain = grain._replace(mottle=0.4 * grain.mottle)
        sheets[4:] = [wall(patches[4], plain, generator)] * 2
    elif float(solid.half_extent.min()) > 0.05:
        sheets[4:] = [drawers(patches[4], plain, generator)] * 2
    return Look(plain, grain, tuple(sheets), (finish,) * len(patches))


def _table(patches: Sequence[Patch], generator: Generator) -> Look:
    """Laminate with a print of wood, a plain coat, or a cloth."""
    tones = choice(generator, (_LAMINATES, _LAMINATES, _TOPS, _CLOTHS))
    plain = shaded(choice(generator, tones), uniform(generator, 0.85, 1.1))
    grain = Grain(mottle=uniform(generator, 0.04, 0.12), spot=uniform(generator, 0.03, 0.2))
    finish = Finish(uniform(generator, 0.1, 0.5), uniform(generator, 15.0, 80.0))
    if tones is _LAMINATES:
        grain = grain._replace(
            rings=uniform(generator, 0.0, 0.06),
            spacing=uniform(generator, 0.015, 0.06),
            fibre=uniform(generator, 0.02, 0.12),
            thread=uniform(generator, 0.003, 0.007),
        )
    elif tones is _CLOTHS:
        grain = grain._replace(speckle=uniform(generator, 0.0, 0.4))
        finish = Finish(0.0, 8.0)
    sheets = [Sheet(0.01, 0.01, plain)] * len(patches)
    sheets[2] = table_top(patches[2], plain, generator)
    return Look(plain, grain, tuple(sheets), (finish,) * len(patches))


def table_top(patch: Patch, plain: Color, generator: Generator) -> Sheet:
    """At times with flat things that are no objects: sheets of paper, a mat, a strip of tape."""
    sheet = Sheet(patch.width, patch.height, plain, _FINE)
    leaves = (((0.21, 0.297), _PAPER), ((0.3, 0.42), shaded(plain, 0.65)), ((0.05, 0.5), (72, 74, 78)))
    for _ in range(choice(generator, (0, 0, 0, 1, 1, 2))):
        size, color = choice(generator, leaves)
        leaf = Sheet(*size, color, _FINE)
        if color == _PAPER:
            rows = Place(0.1, 0.08, 0.8, uniform(generator, 0.1, 0.8))
            leaf.small_print(rows, (90, 90, 96), generator)
        turned = leaf.image.convert("RGBA").rotate(
            uniform(generator, 0.0, 360.0), Image.Resampling.BICUBIC, expand=True
        )
        place = [round(uniform(generator, 0.0, 0.9) * dots) for dots in sheet.size]
        sheet.image.paste(turned, (place[0], place[1]), turned)
    return sheet


def floor(plain: Color, generator: Generator) -> Sheet:
    """A piece of floor that repeats: boards, tiles or carpet."""
    sheet = Sheet(1.2, 1.2, plain, _COARSE)
    columns, rows = choice(generator, ((3, 16), (3, 3), (1, 1)))
    for row in range(rows):
        for column in range(columns):
            left = (column + (0.37 * (row % 3) if rows > columns else 0.0)) / columns
            tone = shaded(plain, uniform(generator, 0.82, 1.12) if rows > columns else 1.0)
            for shift in (0.0, -1.0):
                place = Place(left + shift, row / rows, 1 / columns, 1 / rows)
                sheet.block(place, tone)
                if rows > 1:
                    sheet.pen.rectangle(sheet.dots(place), outline=shaded(plain, 0.6), width=2)
    return sheet


def wall(patch: Patch, plain: Color, generator: Generator) -> Sheet:
    """Paint that fades, a duct or a skirting along it, and posters."""
    sheet = Sheet(patch.width, patch.height, plain, 2 * _COARSE)
    sheet.fade(
        shaded(plain, uniform(generator, 0.6, 1.2)), uniform(generator, 0.0, 0.8), whole(generator, 0, 3)
    )
    if chance(generator, 0.4):
        top, thick = uniform(generator, 0.2, 0.55), uniform(generator, 0.02, 0.06)
        sheet.block(Place(0.0, top, 1.0, thick), shaded(plain, uniform(generator, 0.75, 1.15)))
        sheet.block(Place(0.0, top + thick, 1.0, 0.004), shaded(plain, 0.5))
    for _ in range(whole(generator, 0, 4)):
        place = Place(
            uniform(generator, 0.3, 0.65),
            uniform(generator, 0.1, 0.6),
            *(uniform(generator, 0.02, 0.1) for _ in range(2)),
        )
        sheet.block(
            place,
            shaded(
                choice(generator, (_PAPER, plain, (70, 84, 96), (120, 80, 60))), uniform(generator, 0.5, 1.0)
            ),
        )
        if chance(generator, 0.4):
            sheet.picture(place, generator)
    return sheet


def drawers(patch: Patch, plain: Color, generator: Generator) -> Sheet:
    """The front of a cabinet: drawers or doors, with handles."""
    sheet = Sheet(patch.width, patch.height, plain, _COARSE)
    columns, rows = whole(generator, 1, 3), whole(generator, 1, 4)
    for row in range(rows):
        for column in range(columns):
            place = Place(column / columns, row / rows, 1 / columns, 1 / rows)
            sheet.pen.rectangle(
                sheet.dots(place), outline=shaded(plain, uniform(generator, 0.4, 0.7)), width=3
            )
            handle = Place(place.left + 0.35 / columns, place.top + 0.15 / rows, 0.3 / columns, 0.04)
            sheet.block(handle, shaded(plain, 0.45))
    return sheet
