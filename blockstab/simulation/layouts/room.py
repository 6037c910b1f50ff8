"""The preset `room`: desks, cupboards, chairs and parcels with small things on them, on the floor of a room."""

from __future__ import annotations

import math

import torch

from blockstab.simulation.layouts import desk, objects
from blockstab.simulation.layouts.draws import chance, choice, twist, uniform, whole
from blockstab.simulation.layouts.placing import Structure, about_up, height, shifted, side_by_side, stand
from blockstab.simulation.physics.shapes import chair, table
from blockstab.simulation.physics.solids import Pile, Solid, box, concatenate

REACH = 2.2  # metres from the middle of the floor that a corner may be

_GOAL, _MOST = (75, 90), 95
_STRUCTURES = 40  # drawn at most
_SMALL: tuple[Structure, ...] = (
    desk.standing,
    desk.standing,
    desk.books,
    desk.lying,
    desk.keyboard,
    objects.stack_of_books,
    objects.rider_on_box,
    objects.bottles,
    objects.upright_books,
)


def arrange_room(generator: torch.Generator) -> Pile:
    """Some eighty things: furniture on the floor of a room, and what lies on it.

    Returns:
        A pile in the frame of the floor (right-handed, +y up, metres; the floor is the plane y = 0), where a hand
        lets go of it.
    """
    return side_by_side(generator, STRUCTURES, _GOAL, _MOST, REACH, _STRUCTURES)


def laden_desk(generator: torch.Generator) -> Pile:
    """A desk, with small things on its left and on its right."""
    board = table(_size(generator, (0.7, 0.37, 0.36)))
    return concatenate([stand(board), *_covered(generator, board, 2, 7)])


def cupboard(generator: torch.Generator) -> Pile:
    """A cupboard as high as a hip or a shoulder, with things on it."""
    body = _furniture(generator, (0.38, choice(generator, (0.3, 0.45, 0.6)), 0.24))
    parts = [stand(body)]
    parts += _covered(generator, body, 1, 6)
    return concatenate(parts)


def seat(generator: torch.Generator) -> Pile:
    """A chair."""
    return stand(chair(_size(generator, (0.22, 0.44, 0.23))))


def parcels(generator: torch.Generator) -> Pile:
    """One to three large boxes, one on another."""
    boxes = [_furniture(generator, (0.22, 0.15, 0.18), "carton") for _ in range(whole(generator, 1, 3))]
    boxes.sort(key=lambda each: -float(each.half_extent[0] * each.half_extent[2]))
    parts, on = [], 0.0
    for each in boxes:
        parts.append(stand(each, twist(generator, 0.03), twist(generator, 0.03), on, twist(generator, 0.3)))
        on += height(each)
    return concatenate(parts)


def _covered(generator: torch.Generator, below: Solid, places: int, most: int) -> list[Pile]:
    """Small things in so many places along the top of a solid, at most `most` in each."""
    wide, _, deep = below.half_extent.tolist()
    reach = min(deep, wide / places) - 0.01
    found = []
    for place in range(places):
        if chance(generator, 0.9):
            x = wide * ((2 * place + 1) / places - 1)
            small = side_by_side(generator, _SMALL, (3, most), most, reach)
            turned = small.moved(about_up(twist(generator, math.pi)), torch.zeros(3, dtype=torch.float64))
            found.append(shifted(turned, x=x, y=height(below)))
    return [part for part in found if len(part)]


def _furniture(generator: torch.Generator, usual: tuple[float, float, float], style: str = "block") -> Solid:
    return box(_size(generator, usual), style, density=250.0)


def _size(generator: torch.Generator, usual: tuple[float, float, float]) -> tuple[float, float, float]:
    """Half extents, metres, each up to a fifth more or less than usual."""
    wide, tall, deep = (half * uniform(generator, 0.8, 1.2) for half in usual)
    return wide, tall, deep


STRUCTURES: tuple[Structure, ...] = (laden_desk, laden_desk, laden_desk, cupboard, cupboard, seat, parcels)
