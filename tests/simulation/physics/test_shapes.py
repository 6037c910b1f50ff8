"""Solids have the size they say, and the volume worked out for them."""

from __future__ import annotations

import math

import pytest
import torch
from torch import Tensor

from blockstab.simulation.physics.engine import world
from blockstab.simulation.physics.shapes import (
    bottle,
    bowl,
    chair,
    cylinder,
    l_shape,
    laptop,
    mouse,
    screen,
    sphere,
    table,
)
from blockstab.simulation.physics.solids import Part, Solid, box
from tests.simulation.resting import put
from tests.tolerance import EXACT

pytest.importorskip("mujoco", reason="the extra `sim` is not installed")

SHAPES = [
    (box((0.1, 0.05, 0.08)), 8 * 0.1 * 0.05 * 0.08),
    (cylinder(0.035, 0.05), math.pi * 0.035**2 * 0.1),
    (sphere(0.04), 4 / 3 * math.pi * 0.04**3),
    (l_shape((0.06, 0.06, 0.04), 0.03), 0.08 * (0.12 * 0.03 + 0.09 * 0.03)),
    # A foot of 1 cm, a post of 6 by 1 cm up to half a centimetre into the panel, which is 2 cm thick.
    (
        screen((0.2, 0.18, 0.09), 0.1),
        0.2 * 0.18 * 0.01 + 0.06 * 0.072 * 0.01 + 0.4 * 0.288 * 0.02,
    ),
    # A base of 2 cm over 85 % of the depth, and a lid that is 1 cm thick along the depth.
    (laptop((0.17, 0.1, 0.14), 0.1), 0.34 * 0.238 * 0.02 + 0.34 * 0.18 * 0.01),
    # Six frustums between rings of 24 corners hold 97.18 % of half an ellipsoid.
    (mouse((0.03, 0.02, 0.05)), 0.9718 * 2 / 3 * math.pi * 0.03 * 0.04 * 0.05),
    (table((0.7, 0.37, 0.36)), 1.4 * 0.03 * 0.72 + 2 * 0.03 * 0.71 * 0.69),
    (chair((0.22, 0.44, 0.23)), 0.44 * 0.44 * 0.46 + 0.44 * 0.44 * 0.03),
    (
        bottle(0.04, 0.14),
        math.pi * 0.04**2 * 0.28 * (0.62 + 0.24 * 0.36**2 + 0.14 * (1 + 0.36 + 0.36**2) / 3),
    ),
    # A ring of 20 corners between two radii has the area 10 sin(2 pi / 20) (R^2 - r^2): here the mean of the
    # wall's, 6.4 mm thick, at the foot of 44 mm and at the rim.
    (
        bowl(0.08, 0.035),
        0.07 * 10 * math.sin(math.pi / 10) * 0.0064 * (0.044 + 0.08 - 0.0064) + math.pi * 0.044**2 * 0.0064,
    ),
]


def mass(solid: Solid) -> float:
    model, _ = world(put(solid, 0.0, 1.0))
    return float(model.body_mass[1])


def corners(part: Part) -> Tensor:
    """Points (V, 3) in the frame of its solid that reach as far along its axes as a part does."""
    reach = torch.stack([part.half_extent, -part.half_extent])
    return (reach if part.points is None else part.points) @ part.rotation.T + part.center


@pytest.mark.parametrize(("solid", "volume"), SHAPES, ids=lambda x: x.kind if isinstance(x, Solid) else "")
def test_the_engine_weighs_a_shape_by_its_volume(solid: Solid, volume: float) -> None:
    # A shoulder of 24 corners has 1.1 % less than a round one.
    assert mass(solid) == pytest.approx(solid.density * volume, rel=0.003)


@pytest.mark.parametrize("solid", [solid for solid, _ in SHAPES], ids=lambda solid: solid.kind)
def test_the_parts_fill_the_bounding_box(solid: Solid) -> None:
    points = torch.cat([corners(part) for part in solid.parts])
    assert torch.allclose(points.amin(dim=0), -solid.half_extent, atol=EXACT)
    assert torch.allclose(points.amax(dim=0), solid.half_extent, atol=EXACT)


def test_a_bowl_is_hollow() -> None:
    full = math.pi * 0.08**2 * 0.07
    assert mass(bowl(0.08, 0.035)) < 0.35 * 1500 * full
