"""Make-up of each thing: its colours, its printing, its gloss, its grain."""

from __future__ import annotations

from collections.abc import Sequence

import torch

from blockstab.simulation.appearance import covers, devices, wraps
from blockstab.simulation.appearance.covers import Palette
from blockstab.simulation.appearance.finish import Finish, Grain, Look
from blockstab.simulation.appearance.furniture import furnished
from blockstab.simulation.appearance.lettering import Color, Sheet, shaded
from blockstab.simulation.appearance.meshes import Patch
from blockstab.simulation.appearance.wraps import METAL
from blockstab.simulation.layouts.draws import chance, choice, uniform
from blockstab.simulation.physics.solids import Solid

_PAINTS: tuple[Color, ...] = (
    *((150, 40, 44), (178, 74, 52), (196, 152, 62), (206, 186, 128), (92, 112, 62), (48, 92, 74)),
    *((46, 66, 112), (84, 122, 160), (92, 66, 98), (198, 190, 176), (118, 112, 106), (52, 48, 52)),
    *((204, 200, 192), (190, 116, 68), (166, 60, 84), (120, 86, 62), (70, 110, 118), (214, 204, 160)),
)
_WOODS: tuple[Color, ...] = ((196, 156, 112), (172, 126, 84), (138, 94, 60), (208, 176, 136), (104, 70, 48))


def _palette(paints: Sequence[Color], generator: torch.Generator) -> Palette:
    """Three of a scene's paints, a little faded or soiled."""
    return Palette(*(shaded(choice(generator, paints), uniform(generator, 0.85, 1.12)) for _ in range(3)))


def draw_paints(count: int, generator: torch.Generator) -> tuple[Color, ...]:
    """The paints of a scene of `count` things: so few that some neighbours look alike."""
    return tuple(choice(generator, _PAINTS) for _ in range(max(3, (2 * count + 2) // 3)))


def draw_look(
    solid: Solid, patches: Sequence[Patch], paints: Sequence[Color], generator: torch.Generator
) -> Look:
    """Make a solid up after its style; one of an unknown style is made of wood or painted."""
    colors = _palette(paints, generator)
    if solid.style in ("table", "floor", "wall", "shelf"):
        return furnished(solid, patches, generator)
    if solid.style in ("carton", "book"):
        return _printed(solid, patches, colors, generator)
    if solid.style in ("tin", "can", "bottle", "bowl", "ball", "plate"):
        return _round(solid, patches, colors, generator)
    if solid.style in devices.STYLES:
        return devices.device(solid, patches, colors, generator)
    return _block(solid, patches, colors, generator)


def _printed(solid: Solid, patches: Sequence[Patch], colors: Palette, generator: torch.Generator) -> Look:
    largest = max(patch.width * patch.height for patch in patches)
    order = solid.half_extent.argsort().tolist()
    draw = covers.parcel if chance(generator, 0.15) else covers.carton
    finish = Finish(uniform(generator, 0.1, 0.5), uniform(generator, 10.0, 50.0))
    sheets = []
    for patch in patches:
        if solid.style == "book":
            sheets.append(covers.book(patch, (order[0], order[1]), colors, generator))
        else:
            sheets.append(draw(patch, patch.width * patch.height / largest, colors, generator))
    grain = Grain(mottle=uniform(generator, 0.03, 0.1), spot=uniform(generator, 0.01, 0.06))
    return Look(colors.ground, grain, tuple(sheets), (finish,) * len(patches))


def _block(solid: Solid, patches: Sequence[Patch], colors: Palette, generator: torch.Generator) -> Look:
    if solid.style == "block" and chance(generator, 0.3):
        return _printed(solid, patches, colors, generator)
    if chance(generator, 0.8 if solid.style == "plank" else 0.5):
        plain = shaded(choice(generator, _WOODS), uniform(generator, 0.85, 1.1))
        grain = Grain(
            rings=uniform(generator, 0.03, 0.16),
            spacing=uniform(generator, 0.004, 0.014),
            fibre=uniform(generator, 0.08, 0.25),
            mottle=0.08,
        )
    else:
        plain = colors.ground
        grain = Grain(mottle=uniform(generator, 0.05, 0.14), spot=uniform(generator, 0.01, 0.08))
    tones = (shaded(plain, uniform(generator, 0.94, 1.06)) for _ in patches)
    sheets = tuple(Sheet(0.01, 0.01, tone) for tone in tones)
    finish = Finish(uniform(generator, 0.02, 0.4), uniform(generator, 6.0, 40.0))
    return Look(plain, grain, sheets, (finish,) * len(patches))


def _round(solid: Solid, patches: Sequence[Patch], colors: Palette, generator: torch.Generator) -> Look:
    grain = Grain(mottle=uniform(generator, 0.02, 0.08), spot=uniform(generator, 0.01, 0.05))
    coat = Finish(uniform(generator, 0.4, 1.0), uniform(generator, 30.0, 120.0))
    steel = Finish(uniform(generator, 0.5, 0.9), uniform(generator, 20.0, 60.0), 1.0)
    top = METAL if chance(generator, 0.7) else colors.third
    sheets, finishes = [], []
    for number, patch in enumerate(patches):
        finish = coat
        match solid.style:
            case "ball":
                sheet = wraps.ball(patch, colors, generator)
            case "bowl" | "plate":
                sheet = wraps.bowl(patch, colors, generator)
            case "bottle":
                sheet = wraps.bottle(patch, number >= len(patches) - 3, colors, generator)
            case _ if patch.face == 0:
                sheet = wraps.label_round(patch, colors, generator)
            case _:
                sheet, finish = wraps.lid(patch, top, generator), steel if top == METAL else coat
        sheets.append(sheet)
        finishes.append(finish)
    return Look(colors.ground, grain, tuple(sheets), tuple(finishes))
