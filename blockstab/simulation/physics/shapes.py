"""Everyday shapes beside the box: cylinders, balls, bowls, bottles, brackets, laptops, tables, chairs and more."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import torch
from torch import Tensor

from blockstab.simulation.physics.solids import Part, Solid

_STAVES = 20  # flat pieces of a bowl's wall
_WALL = 0.08  # thickness of a bowl, share of its radius
_FOOT = 0.55  # radius of a bowl's foot, share of its rim's
_BODY, _NECK, _NECK_RADIUS = 0.62, 0.24, 0.36  # of a bottle: share of its height, and of its radius
_ROUND = 24  # corners of a circle in a hull
_PLATE = 0.01  # metres, half the thickness of screens and laptops
_BOARD = 0.015  # metres, half the thickness of tables and of the backs of chairs
_LEAN = 0.15  # how far a laptop's lid leans back, share of its depth


def cylinder(radius: float, half_height: float, style: str = "can", density: float = 600.0) -> Solid:
    """An upright cylinder, metres."""
    half = _vector(radius, half_height, radius)
    return Solid("cylinder", style, half, (_part("cylinder", half),), density)


def sphere(radius: float, style: str = "ball", density: float = 600.0) -> Solid:
    """A ball, metres."""
    half = _vector(radius, radius, radius)
    return Solid("sphere", style, half, (_part("sphere", half),), density)


def bowl(radius: float, half_height: float, style: str = "bowl", density: float = 1500.0) -> Solid:
    """A bowl, open at the top: a flat bottom, and a wall of staves that lean outwards, metres."""
    wall = _WALL * radius
    bottom = _part("cylinder", _vector(_FOOT * radius, wall / 2, _FOOT * radius), y=wall / 2 - half_height)
    staves = [_stave(radius, half_height, wall, k) for k in range(_STAVES)]
    return Solid("bowl", style, _vector(radius, half_height, radius), (bottom, *staves), density)


def bottle(radius: float, half_height: float, style: str = "bottle", density: float = 1000.0) -> Solid:
    """A bottle: a body, a shoulder that narrows, a neck, metres."""
    tall = 2 * half_height
    neck_radius = _NECK_RADIUS * radius
    body = _part(
        "cylinder", _vector(radius, _BODY * half_height, radius), y=_BODY * half_height - half_height
    )
    neck = _part(
        "cylinder", _vector(neck_radius, _NECK * half_height, neck_radius), y=half_height * (1 - _NECK)
    )
    low, high = _BODY * tall - half_height, half_height - _NECK * tall
    shoulder = _hull(torch.cat([_circle(radius, low), _circle(neck_radius, high)]))
    return Solid("bottle", style, _vector(radius, half_height, radius), (body, shoulder, neck), density)


def l_shape(
    half_extent: Sequence[float], thickness: float, style: str = "bracket", density: float = 600.0
) -> Solid:
    """An L in its x-y plane: a foot along x, a post along y at its lower end, both `thickness` metres thick."""
    wide, tall, deep = half_extent
    foot = _part("box", _vector(wide, thickness / 2, deep), y=thickness / 2 - tall)
    post = _part(
        "box", _vector(thickness / 2, tall - thickness / 2, deep), x=thickness / 2 - wide, y=thickness / 2
    )
    return Solid("l_shape", style, _vector(wide, tall, deep), (foot, post), density)


def screen(half_extent: Sequence[float], echo: float, style: str = "screen", density: float = 400.0) -> Solid:
    """A flat screen on a post with a foot, metres; of the panel, infrared light comes back by `echo`."""
    wide, tall, deep = half_extent
    foot = _part("box", _vector(wide / 2, _PLATE / 2, deep), y=_PLATE / 2 - tall)
    post = _part("box", _vector(0.03, 0.2 * tall, _PLATE / 2), y=_PLATE - 0.8 * tall)
    panel = _part("box", _vector(wide, 0.8 * tall, _PLATE), y=0.2 * tall)
    return Solid("screen", style, _vector(wide, tall, deep), (foot, post, replace(panel, echo=echo)), density)


def laptop(half_extent: Sequence[float], echo: float, style: str = "laptop", density: float = 800.0) -> Solid:
    """An open laptop, metres: its lid leans back, and infrared light comes back from it by `echo`."""
    wide, tall, deep = half_extent
    hinge = 2 * _LEAN * deep - deep
    base = _part("box", _vector(wide, _PLATE, deep * (1 - _LEAN)), y=_PLATE - tall, z=deep * _LEAN)
    edges = [
        (2 * _PLATE - tall, hinge + _PLATE),
        (2 * _PLATE - tall, hinge),
        (tall, _PLATE - deep),
        (tall, -deep),
    ]
    lid = _hull(_vector(*(v for x in (-wide, wide) for y, z in edges for v in (x, y, z))).view(-1, 3))
    return Solid("laptop", style, _vector(wide, tall, deep), (base, replace(lid, echo=echo)), density)


def mouse(half_extent: Sequence[float], style: str = "mouse", density: float = 500.0) -> Solid:
    """The upper half of an ellipsoid, as a hull, metres."""
    wide, tall, deep = half_extent
    up = torch.linspace(0.0, math.pi / 2, _ROUND // 4 + 1, dtype=torch.float64)
    rings = [_circle(math.cos(a), math.sin(a)) for a in up.tolist()]
    points = torch.cat(rings) * _vector(wide, 2 * tall, deep) - _vector(0.0, tall, 0.0)
    return Solid("mouse", style, _vector(wide, tall, deep), (_hull(points),), density)


def table(half_extent: Sequence[float], style: str = "block", density: float = 500.0) -> Solid:
    """A board on two panels, metres."""
    wide, tall, deep = half_extent
    top = _part("box", _vector(wide, _BOARD, deep), y=tall - _BOARD)
    sides = [
        _part("box", _vector(_BOARD, tall - _BOARD, deep - _BOARD), x=side * (wide - 3 * _BOARD), y=-_BOARD)
        for side in (-1, 1)
    ]
    return Solid("table", style, _vector(wide, tall, deep), (top, *sides), density)


def chair(half_extent: Sequence[float], style: str = "block", density: float = 300.0) -> Solid:
    """A seat on a block, half as high as the whole, with a back at its -z side, metres."""
    wide, tall, deep = half_extent
    seat = _part("box", _vector(wide, tall / 2, deep), y=-tall / 2)
    back = _part("box", _vector(wide, tall / 2, _BOARD), y=tall / 2, z=_BOARD - deep)
    return Solid("chair", style, _vector(wide, tall, deep), (seat, back), density)


def _stave(radius: float, half_height: float, wall: float, k: int) -> Part:
    """One piece of a bowl's wall: between two angles, from the foot to the rim."""
    # Two staves meet on each axis, so the rim reaches the sides of its bounding box.
    angle = 2 * math.pi / _STAVES * torch.tensor([k, k + 1], dtype=torch.float64)
    rings = []
    for outer, height in ((_FOOT * radius, -half_height), (radius, half_height)):
        for reach in (outer - wall, outer):
            x, z = reach * angle.cos(), reach * angle.sin()
            rings.append(torch.stack([x, torch.full_like(x, height), z], dim=1))
    return _hull(torch.cat(rings))


def _circle(radius: float, height: float) -> Tensor:
    angle = torch.arange(_ROUND, dtype=torch.float64) * (2 * math.pi / _ROUND)
    return torch.stack([radius * angle.cos(), torch.full_like(angle, height), radius * angle.sin()], dim=1)


def _hull(points: Tensor) -> Part:
    low, high = points.amin(dim=0), points.amax(dim=0)
    middle = (low + high) / 2
    return Part("hull", middle, torch.eye(3, dtype=torch.float64), (high - low) / 2, points - middle)


def _part(form: str, half_extent: Tensor, x: float = 0.0, y: float = 0.0, z: float = 0.0) -> Part:
    assert form in ("box", "cylinder", "sphere")
    return Part(form, _vector(x, y, z), torch.eye(3, dtype=torch.float64), half_extent)  # type: ignore[arg-type]


def _vector(*values: float) -> Tensor:
    return torch.tensor(values, dtype=torch.float64)
