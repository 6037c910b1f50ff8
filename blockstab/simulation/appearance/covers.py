"""Prints on cartons and books, face by face."""

from __future__ import annotations

from typing import NamedTuple

import torch
from PIL import Image

from blockstab.simulation.appearance.lettering import Color, Place, Sheet, legible, shaded
from blockstab.simulation.appearance.meshes import Patch
from blockstab.simulation.layouts.draws import chance, choice, uniform, whole

_CARDBOARD: Color = (170, 132, 92)
_PAPER: Color = (222, 212, 190)


class Palette(NamedTuple):
    """The colours of one product."""

    ground: Color
    accent: Color
    third: Color


def front(patch: Patch, palette: Palette, generator: torch.Generator) -> Sheet:
    """The side that sells: a wash, a swoosh, a picture, a name and some print."""
    sheet = Sheet(patch.width, patch.height, palette.ground)
    if chance(generator, 0.7):
        sheet.fade(palette.accent, uniform(generator, 0.3, 1.0), whole(generator, 0, 3))
    if chance(generator, 0.4):
        _halves(sheet, palette, generator)
    if chance(generator, 0.7):
        sheet.swoosh(palette.third, generator)
    if chance(generator, 0.75):
        left, top = uniform(generator, -0.1, 0.35), uniform(generator, 0.3, 0.6)
        sheet.picture(Place(left, top, uniform(generator, 0.4, 0.9), uniform(generator, 0.3, 0.5)), generator)
    _logo(sheet, palette, generator)
    for _ in range(whole(generator, 1, 3)):
        place = Place(
            uniform(generator, 0.04, 0.6), uniform(generator, 0.4, 0.9), 0.35, uniform(generator, 0.05, 0.2)
        )
        sheet.small_print(place, legible(palette.ground, generator), generator)
    if chance(generator, 0.3):
        sheet.oval(Place(0.72, 0.04, 0.22, 0.22 * patch.width / patch.height), palette.accent)
    return sheet


def back(patch: Patch, palette: Palette, generator: torch.Generator) -> Sheet:
    """A narrow side: what is in it, a bar code, a stripe."""
    sheet = Sheet(
        patch.width, patch.height, choice(generator, (palette.ground, palette.ground, palette.third))
    )
    if chance(generator, 0.5):
        sheet.fade(palette.accent, uniform(generator, 0.2, 0.8), whole(generator, 0, 3))
    if chance(generator, 0.6):
        sheet.block(
            Place(0.0, uniform(generator, 0.0, 0.8), 1.0, uniform(generator, 0.05, 0.2)), palette.accent
        )
    if chance(generator, 0.6):
        place = Place(0.08, uniform(generator, 0.05, 0.4), 0.84, uniform(generator, 0.2, 0.5))
        if chance(generator, 0.5):
            sheet.block(place, _PAPER)
        sheet.small_print(place, (48, 46, 52), generator)
    if chance(generator, 0.4):
        sheet.bar_code(Place(uniform(generator, 0.05, 0.5), 0.72, 0.42, 0.2), generator)
    if chance(generator, 0.5):
        sheet.word(Place(0.05, 0.03, 0.9, 0.3), legible(palette.ground, generator), generator)
    return sheet


def carton(patch: Patch, share: float, palette: Palette, generator: torch.Generator) -> Sheet:
    """A face of a folding box, whose area is `share` of that of its largest face."""
    if share > 0.6:
        return front(patch, palette, generator)
    if share > 0.2 or chance(generator, 0.5):
        return back(patch, palette, generator)
    sheet = Sheet(patch.width, patch.height, palette.ground)
    sheet.block(Place(0.0, uniform(generator, 0.3, 0.7), 1.0, 0.02), shaded(palette.ground, 0.6))
    return sheet


def parcel(patch: Patch, share: float, palette: Palette, generator: torch.Generator) -> Sheet:
    """A face of a brown box: tape, and at times a label."""
    sheet = Sheet(patch.width, patch.height, shaded(_CARDBOARD, uniform(generator, 0.85, 1.1)))
    if share < 0.9 and chance(generator, 0.5):
        sheet.block(Place(0.42, 0.0, 0.16, 1.0), (186, 152, 104))
    if chance(generator, 0.5):
        left, top = uniform(generator, 0.05, 0.5), uniform(generator, 0.05, 0.5)
        place = Place(left, top, uniform(generator, 0.25, 0.45), uniform(generator, 0.2, 0.4))
        sheet.block(place, (226, 222, 212))
        sheet.small_print(place, (60, 56, 56), generator)
    return sheet


def book(patch: Patch, axes: tuple[int, int], palette: Palette, generator: torch.Generator) -> Sheet:
    """A face of a book whose covers and whose spine look along the two `axes`."""
    covers, spine = axes
    if patch.face // 2 == covers:
        sheet = Sheet(patch.width, patch.height, palette.ground)
        if chance(generator, 0.6):
            place = Place(0.1, uniform(generator, 0.3, 0.5), 0.8, uniform(generator, 0.2, 0.45))
            sheet.picture(place, generator)
        sheet.word(Place(0.08, 0.08, 0.84, 0.18), legible(palette.ground, generator), generator)
        sheet.small_print(Place(0.25, 0.86, 0.5, 0.05), legible(palette.ground, generator), generator)
        return sheet
    if patch.face == 2 * spine + 1:
        return _spine(patch, palette, generator)
    sheet, (width, height) = Sheet(patch.width, patch.height, _PAPER), (patch.width, patch.height)
    lying = width > height
    for k in torch.arange(0.0, 1.0, 0.0012 / min(width, height)).tolist():
        tone = shaded(_PAPER, uniform(generator, 0.72, 1.05))
        sheet.block(Place(0.0, k, 1.0, 0.03) if lying else Place(k, 0.0, 0.03, 1.0), tone)
    edge = min(0.2, 0.003 / min(width, height))
    for start in (0.0, 1.0 - edge):
        sheet.block(Place(0.0, start, 1.0, edge) if lying else Place(start, 0.0, edge, 1.0), palette.ground)
    return sheet


def _halves(sheet: Sheet, palette: Palette, generator: torch.Generator) -> None:
    """A part of the face, up to two thirds of it, in another colour: print that looks like another thing."""
    share = uniform(generator, 0.2, 0.65)
    place = choice(
        generator,
        (
            Place(0.0, 0.0, 1.0, share),
            Place(0.0, 1.0 - share, 1.0, share),
            Place(0.0, 0.0, share, 1.0),
            Place(1.0 - share, 0.0, share, 1.0),
        ),
    )
    sheet.block(place, choice(generator, (palette.accent, palette.third, _PAPER)))


def _logo(sheet: Sheet, palette: Palette, generator: torch.Generator) -> None:
    place = Place(
        uniform(generator, 0.02, 0.15),
        uniform(generator, 0.04, 0.3),
        uniform(generator, 0.6, 0.85),
        uniform(generator, 0.15, 0.3),
    )
    ground = choice(generator, (palette.accent, palette.third, (228, 224, 214)))
    shape = whole(generator, 0, 2)
    if shape == 1:
        sheet.oval(place, ground)
    elif shape == 2:
        sheet.block(place, ground)
    ink = legible(ground if shape else palette.ground, generator)
    sheet.word(place, ink, generator, uniform(generator, -8.0, 8.0))


def _spine(patch: Patch, palette: Palette, generator: torch.Generator) -> Sheet:
    lying = patch.width > patch.height
    sheet = Sheet(
        max(patch.width, patch.height), min(patch.width, patch.height), shaded(palette.ground, 0.92)
    )
    sheet.word(Place(0.1, 0.1, 0.5, 0.8), legible(palette.ground, generator), generator)
    sheet.block(Place(0.78, 0.0, 0.12, 1.0), palette.accent)
    if not lying:
        sheet.image = sheet.image.transpose(Image.Transpose.ROTATE_90)
        sheet.size = sheet.image.size
    return sheet
