"""The picture that an RGB-D camera takes of a pile in a furnished room."""

from __future__ import annotations

import math
from dataclasses import dataclass

import torch
from torch import Tensor

from blockstab.rgbd.frame import Frame
from blockstab.simulation.appearance.coloring import paint
from blockstab.simulation.appearance.raycasting import NOTHING, RayCaster, Surfaces
from blockstab.simulation.appearance.viewpoint import Viewpoint
from blockstab.simulation.physics.solids import Pile, concatenate
from blockstab.simulation.sensors import Sensor

TABLE = 1  # label id of the table; the objects follow, then the other pieces of the room


@dataclass(frozen=True)
class Picture:
    """An RGB-D image, and what is really in it.

    Args:
        frame: as the sensor delivers it, with true labels.
        total_pixels: (N,) int64, how many pixels each object would cover if nothing stood in front of it.
    """

    frame: Frame
    total_pixels: Tensor


def photograph(
    name: str,
    pile: Pile,
    view: Viewpoint,
    room: Pile,
    sensor: Sensor,
    variety: float,
    generator: torch.Generator,
) -> Picture:
    """Take the picture of a pile in a room.

    Args:
        name: of the frame.
        pile: N solids; the i-th gets the label id `i + 2`.
        room: the furniture, the table first.
        variety: from 0, plain colours under one light, to 1, the full range of materials and lights.

    Convention:
        A label is that of the surface exactly in the middle of the pixel, 0 where there is none. What the sensor
        does not see, as a black thing or the ground in its shadow, has a label all the same, as it would have from
        the hand of whoever labels a photograph. At edges, where depth frays, a pixel may carry the label of one
        surface and the depth of another.
    """
    # Each part draws from its own generator, so that depth does not depend on how colours are drawn.
    colors, noise = (
        torch.Generator().manual_seed(int(torch.randint(2**62, (), generator=generator))) for _ in range(2)
    )
    caster = RayCaster(concatenate([room, pile]))
    seen = caster.first_hit(view.center, view.rays())
    incidence, lit = _incidence(view, seen), _lit(view, seen, caster, sensor)
    depth = sensor.measure(seen.depth, incidence, lit, _echo(seen, caster), noise)
    color = slipped(paint(seen, view, room, pile, caster, variety, colors), sensor.slip_px, colors)
    objects = torch.arange(len(pile)) + TABLE + 1
    behind = torch.arange(len(room) - 1) + TABLE + 1 + len(pile)
    ids = torch.cat([torch.tensor([TABLE]), behind, objects])
    label = torch.where(seen.solid != NOTHING, ids[seen.solid.clamp(min=0)], 0)
    background = (TABLE, *behind.tolist())
    frame = Frame(name, color, depth, view.camera, label, background, view.up_camera())
    return Picture(frame, _total_pixels(pile, view))


def _incidence(view: Viewpoint, seen: Surfaces) -> Tensor:
    """Radians (H, W) between line of sight and surface normal, 0 to pi / 2."""
    rays = view.rays()
    facing: Tensor = -(rays * seen.normals).sum(dim=-1) / rays.norm(dim=-1)
    return facing.clamp(0.0, 1.0).arccos()


def _lit(view: Viewpoint, seen: Surfaces, caster: RayCaster, sensor: Sensor) -> Tensor:
    """Mask (H, W) of the surfaces that the second eye of the sensor sees."""
    eye = view.center + sensor.baseline * view.camera_from_table[0]
    return ~caster.hidden_from(eye.expand_as(seen.points), seen.points)


def _echo(seen: Surfaces, caster: RayCaster) -> Tensor:
    """Share (H, W) of infrared light that comes back."""
    echoes = [patch.echo for patches in caster.patches for patch in patches]
    first = torch.tensor([0, *(len(patches) for patches in caster.patches)]).cumsum(0)
    at = first[seen.solid.clamp(min=0)] + seen.patch
    return torch.tensor(echoes, dtype=torch.float64)[torch.where(seen.solid == NOTHING, 0, at)]


def slipped(color: Tensor, slip_px: float, generator: torch.Generator) -> Tensor:
    """A colour image (H, W, 3) that is off by whole pixels, as where it is badly registered to depth.

    Args:
        slip_px: standard deviation along rows and columns; at most three times that happens.
    """
    off = (slip_px * torch.randn(2, generator=generator).clamp(-3.0, 3.0)).round().long().tolist()
    rows, columns = ((torch.arange(n) + d).clamp(0, n - 1) for n, d in zip(color.shape[:2], off, strict=True))
    return color[rows][:, columns]


def _total_pixels(pile: Pile, view: Viewpoint) -> Tensor:
    """Pixels (N,) that each object alone would cover."""
    height, width = view.size
    counts = []
    for i, corners in enumerate(view.pixels(pile.boxes().corners())):
        low, high = corners[:, :2].amin(dim=0).tolist(), corners[:, :2].amax(dim=0).tolist()
        rows = _pixels_between(low[1], high[1], height)
        columns = _pixels_between(low[0], high[0], width)
        rays = view.rays_at(*torch.meshgrid(rows.double(), columns.double(), indexing="ij"))
        counts.append(int(RayCaster(pile[[i]]).meets(view.center, rays).sum()))
    return torch.tensor(counts)


def _pixels_between(low: float, high: float, size: int) -> Tensor:
    """Rows or columns of a picture between two places; none where both are on one side of it."""
    first, end = max(0, math.floor(low)), min(size, math.ceil(high) + 1)
    return torch.arange(first, max(first, end))
