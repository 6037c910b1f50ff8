"""Prints on tins, bottles, balls and bowls, patch by patch."""

from __future__ import annotations

import math

import torch

from blockstab.simulation.appearance.covers import Palette, front
from blockstab.simulation.appearance.lettering import Color, Place, Sheet, shaded
from blockstab.simulation.appearance.meshes import Patch
from blockstab.simulation.layouts.draws import chance, uniform, whole

METAL: Color = (206, 206, 202)


def label_round(patch: Patch, palette: Palette, generator: torch.Generator) -> Sheet:
    """The label round a tin, with its front twice, and a metal rim above and below."""
    turned = patch._replace(width=patch.width / 2)
    sheet, half = Sheet(patch.width, patch.height, palette.ground), front(turned, palette, generator)
    for start in (0, half.size[0]):
        sheet.image.paste(half.image, (start, 0))
    rim = min(0.1, 0.004 / patch.height)
    for top in (0.0, 1.0 - rim):
        sheet.block(Place(0.0, top, 1.0, rim), METAL)
        sheet.block(Place(0.0, top + 0.4 * rim, 1.0, 0.2 * rim), shaded(METAL, 0.5))
    return sheet


def lid(patch: Patch, color: Color, generator: torch.Generator) -> Sheet:
    """The end of a tin: rings, one inside the other."""
    sheet = Sheet(patch.width, patch.height, shaded(color, 0.9))
    for inset in (0.02, 0.06, uniform(generator, 0.1, 0.3)):
        for shift, light in ((0.0, 0.55), (0.008, 1.1), (0.016, uniform(generator, 0.8, 1.0))):
            far = inset + shift
            sheet.oval(Place(far, far, 1.0 - 2 * far, 1.0 - 2 * far), shaded(color, light))
    return sheet


def bottle(patch: Patch, highest: bool, palette: Palette, generator: torch.Generator) -> Sheet:
    """A part of a bottle: with a label round what is tall, and a cap on the highest part."""
    sheet = Sheet(patch.width, patch.height, palette.ground)
    if highest:
        sheet.block(Place(0.0, 0.0, 1.0, 0.55 if patch.face == 0 else 1.0), palette.third)
    elif patch.form == "cylinder" and patch.face == 0 and patch.height > 0.06:
        low, tall = uniform(generator, 0.1, 0.3), uniform(generator, 0.4, 0.6)
        around = patch._replace(height=patch.height * tall)
        label = label_round(around, palette._replace(ground=palette.accent), generator)
        sheet.image.paste(label.image, (0, round(low * sheet.size[1])))
    return sheet


def ball(patch: Patch, palette: Palette, generator: torch.Generator) -> Sheet:
    """Panels in one or two colours, and seams between them."""
    sheet, panels = Sheet(patch.width, patch.height, palette.ground), whole(generator, 2, 6)
    width, height = sheet.size
    for k in range(0, panels, 2 if chance(generator, 0.6) else panels):
        sheet.block(Place(k / panels, 0.0, 1.0 / panels, 1.0), palette.accent)
    for start in range(2 * panels):
        rows = range(0, height, 4)
        bend = 0.15 * width / panels
        line = [(width * start / (2 * panels) + bend * math.sin(2 * math.pi * y / height), y) for y in rows]
        sheet.pen.line(line, fill=shaded(palette.ground, 0.4), width=3)
    return sheet


def bowl(patch: Patch, palette: Palette, generator: torch.Generator) -> Sheet:
    """Glaze, often with a band or a darker rim round the wall, which is made of hulls."""
    sheet = Sheet(patch.width, patch.height, palette.ground)
    if patch.form != "hull":
        return sheet
    if chance(generator, 0.5):
        sheet.fade(palette.accent, uniform(generator, 0.1, 0.6), whole(generator, 0, 1) * 2)
    if chance(generator, 0.6):
        sheet.block(
            Place(0.0, uniform(generator, 0.0, 0.4), 1.0, uniform(generator, 0.03, 0.15)), palette.third
        )
    return sheet
