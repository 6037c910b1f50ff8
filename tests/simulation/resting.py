"""Piles at rest, small enough to be worked out by hand."""

from __future__ import annotations

import math

import torch
from torch import Tensor

from blockstab.simulation.physics.settling import settle
from blockstab.simulation.physics.solids import Pile, Solid, box, concatenate


def put(solid: Solid, x: float, y: float, z: float = 0.0, lean_deg: float = 0.0) -> Pile:
    """One solid with its centre at x, y, z, metres, turned about +z."""
    return Pile((solid,), torch.tensor([[x, y, z]], dtype=torch.float64), about_z(lean_deg)[None])


def about_z(degrees: float) -> Tensor:
    """Rotation (3, 3) about +z."""
    c, s = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
    return torch.tensor([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]], dtype=torch.float64)


def rested(*parts: Pile) -> Pile:
    """The pile of all parts, settled."""
    resting = settle(concatenate(parts))
    assert resting is not None
    return resting


def tower() -> Pile:
    """Three blocks, each on the one before."""
    return rested(
        put(box((0.06, 0.04, 0.05)), 0.0, 0.041),
        put(box((0.05, 0.04, 0.05)), 0.01, 0.122),
        put(box((0.04, 0.04, 0.05)), 0.0, 0.203, 0.01),
    )


def bridge() -> Pile:
    """Two equal pillars and a beam."""
    pillars = [put(box((0.03, 0.05, 0.05)), x, 0.051) for x in (-0.08, 0.08)]
    return rested(*pillars, put(box((0.12, 0.03, 0.05)), 0.0, 0.132))


def seesaw() -> Pile:
    """A beam that reaches so far out that only the block on its inner end holds it."""
    base, beam = put(box((0.05, 0.05, 0.05)), 0.0, 0.051), put(box((0.12, 0.03, 0.04)), 0.07, 0.132)
    return rested(base, beam, put(box((0.04, 0.07, 0.04)), -0.01, 0.233))


def leaning_plank() -> Pile:
    """A plank whose lower end is on the table, and whose lower face is on the edge of a block."""
    slope, half_length, half_thick = math.radians(30.0), 0.12, 0.01
    height = 2 * 1.6 * half_length * math.sin(slope) / 2
    c, s = math.cos(slope), math.sin(slope)
    x, y = half_length * c - half_thick * s, half_length * s + half_thick * c
    edge = height / math.tan(slope)
    block = put(box((0.05, height / 2, 0.05)), edge + 0.05, height / 2 + 0.001)
    return rested(block, put(box((half_length, half_thick, 0.04), "plank"), x, y + 0.002, 0.0, 30.0))
