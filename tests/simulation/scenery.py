"""Hand-made solids and piles, furnished and seen."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import torch

from blockstab.boxes.box import Boxes
from blockstab.rgbd.frame import Camera
from blockstab.simulation.appearance.lighting import Lamps
from blockstab.simulation.appearance.raycasting import RayCaster, Surfaces
from blockstab.simulation.appearance.room import furnish
from blockstab.simulation.appearance.viewpoint import Setting, Viewpoint, draw_view
from blockstab.simulation.physics.solids import Part, Pile, Solid, box, concatenate
from blockstab.simulation.sensors import Kinect

# A Kinect with a quarter of its pixels: pictures are as wide as they are, and made sooner.
KINECT = Kinect(Camera(fx=262.5, fy=262.5, cx=159.5, cy=119.5), height_px=240, width_px=320)


def of_one_part(form: str, half: Sequence[float], style: str, product: int | None = None) -> Solid:
    """A box, cylinder or sphere of one part."""
    extent = torch.tensor(half, dtype=torch.float64)
    middle, axes = torch.zeros(3, dtype=torch.float64), torch.eye(3, dtype=torch.float64)
    part = Part(form, middle, axes, extent)  # type: ignore[arg-type]
    return Solid(form, style, extent, (part,), product=product)


def standing(*places: tuple[Solid, float, float]) -> Pile:
    """Upright solids on the table, each at x and z, metres."""
    center = [[x, float(solid.half_extent[1]), z] for solid, x, z in places]
    axes = torch.eye(3, dtype=torch.float64).repeat(len(places), 1, 1)
    return Pile(tuple(solid for solid, _, _ in places), torch.tensor(center, dtype=torch.float64), axes)


def lamps_at(x: float, radius: float = 0.05) -> Lamps:
    """One lamp to the side of the pile, and no second one."""
    position = torch.tensor([[x, 1.0, 0.0], [0.0, 2.0, 0.0]])
    color = torch.tensor([[1.0] * 3, [0.0] * 3])
    sky, ground = torch.full((3,), 0.2), torch.full((3,), 0.1)
    return Lamps(position, torch.full((2,), radius), color, sky, ground, torch.zeros(3))


class Scenery(NamedTuple):
    """A pile in a room, and what a camera sees of them."""

    pile: Pile
    room: Pile
    view: Viewpoint
    caster: RayCaster
    seen: Surfaces


def scenery(pile: Pile, seed: int, setting: Setting = "table") -> Scenery:
    """Furnish a room round a pile and look at it with a Kinect."""
    generator = torch.Generator().manual_seed(seed)
    view = draw_view(generator, pile, KINECT, setting)
    room = furnish(generator, view, pile, setting)
    caster = RayCaster(concatenate([room, pile]))
    return Scenery(pile, room, view, caster, caster.first_hit(view.center, view.rays()))


def pile_of_boxes(boxes: Boxes) -> Pile:
    """A pile of N boxes, each a solid of one part."""
    solids = tuple(box(half, "block") for half in boxes.half_extent.tolist())
    return Pile(solids, boxes.center, boxes.rotation)
