"""Everyday things by name: their shape, size and weight, each drawn a little larger or smaller."""

from __future__ import annotations

from dataclasses import dataclass, replace

import torch

from blockstab.simulation.layouts.draws import chance, uniform
from blockstab.simulation.physics.shapes import bottle, bowl, cylinder, l_shape, laptop, mouse, screen, sphere
from blockstab.simulation.physics.solids import Solid, box

_VARIES = 0.2  # of every length, up or down
_FAINT = (0.03, 0.4)  # share of infrared light that comes back from what is black and glossy
_DARK = 0.07  # share of all things that are


@dataclass(frozen=True)
class Product:
    """A kind of thing as it comes in many sizes.

    Args:
        style: what it is made up as; that also decides its shape.
        size: width, height and depth where it stands as it should, metres; width is depth where it is round.
        density: kg per cubic metre.
    """

    style: str
    size: tuple[float, float, float]
    density: float


PRODUCTS = {
    "cereal": Product("carton", (0.19, 0.30, 0.07), 180.0),
    "crackers": Product("carton", (0.15, 0.21, 0.06), 250.0),
    "tea": Product("carton", (0.15, 0.08, 0.07), 250.0),
    "biscuits": Product("carton", (0.20, 0.06, 0.09), 350.0),
    "juice": Product("carton", (0.07, 0.20, 0.07), 1000.0),
    "rice": Product("carton", (0.10, 0.15, 0.05), 800.0),
    "soup": Product("can", (0.066, 0.10, 0.066), 1000.0),
    "tuna": Product("can", (0.085, 0.045, 0.085), 1000.0),
    "beans": Product("can", (0.074, 0.11, 0.074), 1000.0),
    "water": Product("bottle", (0.08, 0.28, 0.08), 1000.0),
    "sauce": Product("bottle", (0.064, 0.20, 0.064), 1000.0),
    "book": Product("book", (0.24, 0.03, 0.17), 700.0),
    "crate": Product("block", (0.16, 0.10, 0.14), 400.0),
    "parcel": Product("carton", (0.20, 0.13, 0.15), 300.0),
    "tea tin": Product("tin", (0.10, 0.12, 0.10), 600.0),
    "cake tin": Product("tin", (0.18, 0.08, 0.18), 300.0),
    "ball": Product("ball", (0.06, 0.06, 0.06), 200.0),
    "bowl": Product("bowl", (0.17, 0.07, 0.17), 1500.0),
    "bracket": Product("bracket", (0.12, 0.12, 0.08), 1000.0),
    "monitor": Product("screen", (0.46, 0.36, 0.18), 400.0),
    "laptop": Product("laptop", (0.33, 0.21, 0.29), 800.0),
    "keyboard": Product("keyboard", (0.42, 0.022, 0.14), 500.0),
    "mouse": Product("mouse", (0.06, 0.036, 0.11), 500.0),
    "pen": Product("pen", (0.013, 0.14, 0.013), 900.0),
    "tool": Product("tool", (0.025, 0.013, 0.17), 1500.0),
    "phone": Product("phone", (0.075, 0.013, 0.15), 1500.0),
    "plate": Product("plate", (0.24, 0.025, 0.24), 2000.0),
    "cup": Product("bowl", (0.085, 0.09, 0.085), 1200.0),
    "tube": Product("can", (0.075, 0.24, 0.075), 300.0),
}


def draw_product(generator: torch.Generator, name: str, number: int | None = None) -> Solid:
    """One of the `PRODUCTS`; each of its lengths up to 20 % more or less than usual.

    Args:
        number: of its `Solid.product`, for things that look alike.
    """
    product = PRODUCTS[name]
    wide, tall, deep = (0.5 * s * uniform(generator, 1.0 - _VARIES, 1.0 + _VARIES) for s in product.size)
    faint = uniform(generator, *_FAINT)
    solid = _shaped(product.style, (wide, tall, deep), faint)
    if chance(generator, _DARK):
        solid = replace(solid, parts=tuple(replace(part, echo=faint) for part in solid.parts))
    return replace(solid, density=product.density, product=number)


def _shaped(style: str, half: tuple[float, float, float], faint: float) -> Solid:
    """The solid of a style in the box of these half extents, metres; round ones take their width for depth."""
    wide, tall, _deep = half
    match style:
        case "can" | "tin" | "pen":
            return cylinder(wide, tall, style)
        case "bottle":
            return bottle(wide, tall)
        case "bowl" | "plate":
            return bowl(wide, tall, style)
        case "ball":
            return sphere(wide)
        case "bracket":
            return l_shape(half, 0.02)
        case "screen":
            return screen(half, faint)
        case "laptop":
            return laptop(half, faint)
        case "mouse":
            return mouse(half)
        case _:
            return box(half, style)
