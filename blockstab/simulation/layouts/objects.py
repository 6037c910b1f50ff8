"""The preset `objects`: books, tins, bowls, bottles and boxes piled, leaning and in heaps (the paper's SOD)."""

from __future__ import annotations

import math

import torch

from blockstab.simulation.layouts.draws import any_turn, chance, choice, twist, uniform, whole
from blockstab.simulation.layouts.placing import (
    Structure,
    about,
    clear,
    height,
    leaning,
    shifted,
    side_by_side,
    stand,
)
from blockstab.simulation.layouts.products import draw_product
from blockstab.simulation.physics.solids import Pile, Solid, concatenate

_GOAL, _MOST = (5, 11), 15
_FLAT_TOPPED = ("crate", "parcel", "tea tin", "cake tin")
_RIDERS = ("tea tin", "soup", "bowl", "tea", "sauce", "cake tin", "bracket")
_HEAPED = ("book", "tea", "tuna", "soup", "ball", "sauce", "bracket", "crackers")
_BESIDE_BOTTLES = (*_FLAT_TOPPED, "bowl", "bracket", "sauce", "ball")
_STEP = 0.01  # metres, by which things of a heap are raised until they are clear


def arrange_objects(generator: torch.Generator) -> Pile:
    """Five to fifteen things: stacks, things on boxes, things in bowls, books that lean, heaps.

    Returns:
        A pile in the table frame (right-handed, +y up, metres; the table is the plane y = 0), where a hand
        lets go of it: most a millimetre or two above what they are to rest on, those of a heap higher.
    """
    return side_by_side(generator, STRUCTURES, _GOAL, _MOST)


def stack_of_books(generator: torch.Generator) -> Pile:
    """Two to four books, each turned a little, at times with something on them."""
    parts, on = books_on_books(generator, whole(generator, 2, 4), 0.4)
    if chance(generator, 0.6):
        parts.append(_rider(generator, on, 0.03))
    return concatenate(parts)


def books_on_books(generator: torch.Generator, count: int, turn: float) -> tuple[list[Pile], float]:
    """So many books, each turned by at most `turn` radians, and how high the last one ends, metres."""
    parts, on = [], 0.0
    for _ in range(count):
        book = draw_product(generator, "book")
        parts.append(
            stand(book, twist(generator, 0.015), twist(generator, 0.015), on, twist(generator, turn))
        )
        on += height(book)
    return parts, on


def rider_on_box(generator: torch.Generator) -> Pile:
    """Something on a box or a broad tin."""
    below = draw_product(generator, choice(generator, _FLAT_TOPPED))
    return concatenate([stand(below), _rider(generator, height(below), 0.02)])


def _rider(generator: torch.Generator, on: float, off: float) -> Pile:
    solid = draw_product(generator, choice(generator, _RIDERS))
    return stand(solid, twist(generator, off), twist(generator, off), on, twist(generator, math.pi))


def stack_of_boxes(generator: torch.Generator) -> Pile:
    """Two or three boxes of different sizes, the largest below."""
    boxes = [draw_product(generator, choice(generator, ("crate", "parcel", "tea"))) for _ in range(3)]
    boxes.sort(key=lambda each: -float(each.half_extent[0] * each.half_extent[2]))
    parts, on = [], 0.0
    for each in boxes[: whole(generator, 2, 3)]:
        parts.append(stand(each, twist(generator, 0.02), twist(generator, 0.02), on, twist(generator, 0.5)))
        on += height(each)
    return concatenate(parts)


def ball_in_bowl(generator: torch.Generator) -> Pile:
    """A ball a little above the bottom of a bowl, which stands on a book or on the table."""
    bowl, ball = draw_product(generator, "bowl"), draw_product(generator, "ball")
    below = [stand(draw_product(generator, "book"))] if chance(generator, 0.4) else []
    on = sum(height(part.solids[0]) for part in below)
    inside = stand(ball, on=on + 0.3 * height(bowl))
    return concatenate([*below, stand(bowl, on=on), inside])


def leaning_book(generator: torch.Generator) -> Pile:
    """A book with one end on the table and its lower side on the edge of a box or on the rim of a tin."""
    book = draw_product(generator, "book")
    support = draw_product(generator, choice(generator, ("crate", "parcel", "tea", "cake tin", "beans")))
    edge, long = height(support), float(book.half_extent[0])
    slope = math.asin(min(0.9, edge / (uniform(generator, 1.2, 1.7) * long)))
    return concatenate([stand(support), leaning(book, slope, edge, -float(support.half_extent[0]))])


def book_on_tins(generator: torch.Generator) -> Pile:
    """A book across two equal tins or cans, at times with something on it."""
    tin = draw_product(generator, choice(generator, ("soup", "tuna", "beans")))
    book = draw_product(generator, "book")
    apart = uniform(generator, 0.55, 0.75) * float(book.half_extent[0])
    parts = [stand(tin, side * apart, twist(generator, 0.01)) for side in (-1, 1)]
    parts.append(stand(book, on=height(tin), yaw=twist(generator, 0.1)))
    if chance(generator, 0.5):
        parts.append(_rider(generator, height(tin) + height(book), 0.02))
    return concatenate(parts)


def upright_books(generator: torch.Generator) -> Pile:
    """Two to four books side by side on their ends, at a box."""
    end = draw_product(generator, choice(generator, ("crate", "parcel")))
    parts, x = [stand(end)], float(end.half_extent[0])
    for _ in range(whole(generator, 2, 4)):
        book = draw_product(generator, "book")
        thick = height(book)
        parts.append(stand(book, x + thick / 2, tilt=about(2, math.pi / 2)))
        x += thick + uniform(generator, 0.0, 0.002)
    return shifted(concatenate(parts), x=-x / 2)


def lying_tin(generator: torch.Generator) -> Pile:
    """A can on its side at the foot of a box."""
    box = draw_product(generator, choice(generator, ("crate", "parcel")))
    can = draw_product(generator, choice(generator, ("soup", "beans", "tea tin")))
    lying = stand(can, tilt=about(0, math.pi / 2))
    x = float(box.half_extent[0] + can.half_extent[0]) + 0.0005
    return concatenate([stand(box), shifted(lying, x=x), _rider(generator, height(box), 0.02)])


def bottles(generator: torch.Generator) -> Pile:
    """A bottle close to another one, a bowl, a tin, a bracket, a ball or a box."""
    names = (choice(generator, ("water", "sauce")), choice(generator, _BESIDE_BOTTLES))
    parts, x = [], 0.0
    for name in names:
        solid = draw_product(generator, name)
        half = float(solid.half_extent[0])
        parts.append(stand(solid, x + half, twist(generator, 0.03)))
        x += 2 * half + uniform(generator, 0.0005, 0.01)
    return shifted(concatenate(parts), x=-x / 2)


def heap(generator: torch.Generator) -> Pile:
    """Three to five things let go one above another, each turned at random."""
    pile = _tossed(generator, draw_product(generator, choice(generator, _HEAPED)))
    for _ in range(whole(generator, 2, 4)):
        thing = _tossed(generator, draw_product(generator, choice(generator, _HEAPED)))
        while not clear(thing, pile, _STEP / 2):
            thing = shifted(thing, y=_STEP)
        pile = concatenate([pile, thing])
    return pile


def _tossed(generator: torch.Generator, solid: Solid) -> Pile:
    return stand(solid, twist(generator, 0.06), twist(generator, 0.06), tilt=any_turn(generator))


STRUCTURES: tuple[Structure, ...] = (
    stack_of_books,
    rider_on_box,
    rider_on_box,
    stack_of_boxes,
    ball_in_bowl,
    leaning_book,
    book_on_tins,
    upright_books,
    lying_tin,
    bottles,
    heap,
)
