"""Looks of things: colour, print, gloss and grain."""

from __future__ import annotations

from typing import NamedTuple

from blockstab.simulation.appearance.lettering import Color, Sheet


class Finish(NamedTuple):
    """Specular reflection of a surface.

    Args:
        gloss: 0 for none, 1 for a smooth coat.
        sharpness: exponent of the highlight.
        metal: 0 or 1.
    """

    gloss: float
    sharpness: float
    metal: float = 0.0


class Grain(NamedTuple):
    """Variation of the colour inside the material: strengths, and sizes in metres.

    Args:
        rings, spacing: of wood, and from ring to ring.
        fibre, thread: along the longest side, and how thick.
        mottle, spot: in all directions, and how wide.
        speckle: small dark or (negative) pale specks.
    """

    rings: float = 0.0
    spacing: float = 0.01
    fibre: float = 0.0
    thread: float = 0.003
    mottle: float = 0.05
    spot: float = 0.05
    speckle: float = 0.0


class Look(NamedTuple):
    """The make-up of a solid: a plain colour, a grain, and for each patch a print and a finish."""

    plain: Color
    grain: Grain
    sheets: tuple[Sheet, ...]
    finishes: tuple[Finish, ...]
