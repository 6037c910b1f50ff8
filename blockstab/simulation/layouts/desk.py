"""The preset `desk`: screens, laptops, keyboards, pens, tools, plates and cups, side by side on a table."""

from __future__ import annotations

import math

import torch

from blockstab.simulation.layouts.draws import chance, choice, twist, uniform, whole
from blockstab.simulation.layouts.objects import books_on_books
from blockstab.simulation.layouts.placing import Structure, about, side_by_side, stand
from blockstab.simulation.layouts.products import draw_product
from blockstab.simulation.physics.solids import Pile, concatenate

_GOAL, _MOST = (5, 13), 16
_STANDING = ("cup", "soup", "tube", "bowl", "water", "juice", "tea", "beans", "phone", "mouse", "ball")


def arrange_desk(generator: torch.Generator) -> Pile:
    """Five to sixteen things as they lie about on desks and laid tables: most of them flat, thin or dark.

    Returns:
        A pile in the table frame (right-handed, +y up, metres; the table is the plane y = 0), where a hand
        lets go of it.
    """
    return side_by_side(generator, STRUCTURES, _GOAL, _MOST)


def workplace(generator: torch.Generator) -> Pile:
    """A screen or a laptop, at times a keyboard before it."""
    machine = draw_product(generator, choice(generator, ("monitor", "laptop")))
    parts = [stand(machine)]
    if chance(generator, 0.4):
        keyboard = draw_product(generator, "keyboard")
        apart = float(machine.half_extent[2] + keyboard.half_extent[2]) + uniform(generator, 0.01, 0.06)
        parts.append(stand(keyboard, twist(generator, 0.04), apart))
    return concatenate(parts)


def keyboard(generator: torch.Generator) -> Pile:
    """A keyboard, at times with a mouse beside it."""
    board = draw_product(generator, "keyboard")
    parts = [stand(board)]
    if chance(generator, 0.5):
        mouse = draw_product(generator, "mouse")
        apart = float(board.half_extent[0] + mouse.half_extent[0]) + uniform(generator, 0.02, 0.06)
        parts.append(stand(mouse, apart))
    return concatenate(parts)


def lying(generator: torch.Generator) -> Pile:
    """A pen or a tool."""
    if chance(generator, 0.5):
        return stand(draw_product(generator, "pen"), tilt=about(0, math.pi / 2))
    return stand(draw_product(generator, "tool"))


def standing(generator: torch.Generator) -> Pile:
    """Something by itself."""
    return stand(draw_product(generator, choice(generator, _STANDING)))


def books(generator: torch.Generator) -> Pile:
    """One to three books, at times with something on them."""
    parts, on = books_on_books(generator, whole(generator, 1, 3), 0.3)
    if chance(generator, 0.4):
        rider = draw_product(generator, choice(generator, ("phone", "cup", "tool", "mouse", "tea")))
        parts.append(
            stand(rider, twist(generator, 0.03), twist(generator, 0.02), on, twist(generator, math.pi))
        )
    return concatenate(parts)


def laid(generator: torch.Generator) -> Pile:
    """A plate with tools to its sides."""
    plate = draw_product(generator, "plate")
    parts = [stand(plate)]
    for side in (-1, 1)[: whole(generator, 0, 2)]:
        tool = draw_product(generator, "tool")
        apart = float(plate.half_extent[0] + tool.half_extent[0]) + uniform(generator, 0.005, 0.03)
        parts.append(stand(tool, side * apart, twist(generator, 0.02)))
    return concatenate(parts)


STRUCTURES: tuple[Structure, ...] = (
    workplace,
    keyboard,
    lying,
    lying,
    standing,
    standing,
    books,
    laid,
)
