"""Everyday shapes beside the box: cylinders, balls, bowls, bottles, brackets."""

from __future__ import annotations

import math
from collections.abc import Sequence

import torch
from torch import Tensor

from blockstab.simulation.solids import Part, Solid

_STAVES = 20  # flat pieces of a bowl's wall
_WALL = 0.08  # thickness of a bowl, share of its radius
_FOOT = 0.55  # radius of a bowl's foot, share of its rim's
_BODY, _NECK, _NECK_RADIUS = 0.62, 0.24, 0.36  # of a bottle: share of its height, and of its radius
_ROUND = 24  # corners of a circle in a hull


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


def _part(form: str, half_extent: Tensor, x: float = 0.0, y: float = 0.0) -> Part:
    assert form in ("box", "cylinder", "sphere")
    return Part(form, _vector(x, y, 0.0), torch.eye(3, dtype=torch.float64), half_extent)  # type: ignore[arg-type]


def _vector(*values: float) -> Tensor:
    return torch.tensor(values, dtype=torch.float64)
