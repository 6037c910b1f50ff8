"""Light in a room: two lamps with soft shadows, daylight from all around, and gloss."""

from __future__ import annotations

import math
from dataclasses import dataclass

import torch
from torch import Tensor

from blockstab.simulation.appearance.noise import SolidNoise
from blockstab.simulation.appearance.viewpoint import Viewpoint

_WARM, _COOL = torch.tensor([1.0, 0.78, 0.52]), torch.tensor([0.86, 0.96, 1.12])


@dataclass(frozen=True)
class Lamps:
    """The light in a room.

    Args:
        position: (2, 3) float32 metres, of a main and a weaker lamp.
        radius: (2,) of the lamps, metres.
        color: (2, 3) linear RGB that each sends to the middle of the pile.
        sky, ground: (3,) linear RGB from all around, from above and from below.
        middle: (3,) of the pile, metres.
    """

    position: Tensor
    radius: Tensor
    color: Tensor
    sky: Tensor
    ground: Tensor
    middle: Tensor

    def toward(self, points: Tensor, lamp: int) -> tuple[Tensor, Tensor]:
        """Unit directions (M, 3) from points to a lamp, and its strength there against that at the middle, (M,)."""
        offset = self.position[lamp] - points
        square = (offset * offset).sum(dim=-1)
        at_middle = (self.position[lamp] - self.middle).square().sum()
        return offset / square.sqrt()[:, None], at_middle / square


def draw_lamps(view: Viewpoint, middle: Tensor, variety: float, generator: torch.Generator) -> Lamps:
    """A main lamp above, on the camera's side of the pile, a weaker one, and a rest from all around.

    Args:
        middle: (3,) of the pile, metres.
        variety: 0 for one white lamp from one direction, 1 for all there are.
    """
    share = torch.rand(12, generator=generator)
    outward = view.center - middle
    front = math.atan2(float(outward[2]), float(outward[0]))
    position, radius = [], []
    for turn, height, size in (share[0:3].tolist(), share[3:6].tolist()):
        azimuth = front + math.radians(40.0 + variety * (80.0 * (2 * turn - 1) - 40.0))
        elevation = math.radians(50.0 + variety * (45.0 * height - 20.0))
        flat = 2.0 * math.cos(elevation)
        position.append([flat * math.cos(azimuth), 2.0 * math.sin(elevation), flat * math.sin(azimuth)])
        radius.append(0.12 + 0.3 * variety * size)
    tint = torch.lerp(_WARM, _COOL, share[6:9, None])
    tint = torch.lerp(torch.ones(3), tint, 0.8 * variety)
    sky = (0.2 + variety * (0.25 * share[9] - 0.1)) * tint[2]
    second = variety * (0.05 + 0.3 * share[10])
    center = middle.to(torch.float32)
    return Lamps(
        center + torch.tensor(position),
        torch.tensor(radius),
        torch.stack([tint[0], second * tint[1]]),
        sky,
        0.65 * sky + 0.12 * tint[0],
        center,
    )


def lit(albedo: Tensor, normals: Tensor, points: Tensor, share: Tensor, lamps: Lamps) -> Tensor:
    """Linear RGB (M, 3) that matt surfaces send to the eye: Lambert's law, and light from all around."""
    above = 0.5 + 0.5 * normals[:, 1:2]
    light = torch.lerp(lamps.ground, lamps.sky, above) * share[:, 2:3] ** 1.25
    for lamp in (0, 1):
        direction, strength = lamps.toward(points, lamp)
        facing = (normals * direction).sum(dim=-1).clamp(min=0.0)
        light += lamps.color[lamp] * (facing * strength * share[:, lamp])[:, None]
    # What is pale and boxed in is lit by its own kind: corners of bright things are not grey.
    return albedo * light * (1.0 + 0.4 * albedo * (1.0 - share[:, 2:3]))


def gloss(
    albedo: Tensor,
    finish: Tensor,
    normals: Tensor,
    points: Tensor,
    eye: Tensor,
    share: Tensor,
    lamps: Lamps,
    noise: SolidNoise,
) -> Tensor:
    """Linear RGB (M, 3) that surfaces mirror: highlights (Blinn 1977) and the room (Fresnel after Schlick 1994).

    Args:
        finish: (M, 3) gloss, sharpness, metal.
        share: (M, 4) of the two lamps, the sky and the mirrored room that reach the points, as in `Openness`.
        eye: (3,) float32, where the camera is.
    """
    strength, sharpness, metal = finish.unbind(dim=1)
    to_eye = unit(eye - points)
    facing = (normals * to_eye).sum(dim=-1).clamp(0.0, 1.0)
    base = 0.04 + 0.5 * metal
    mirrored = (strength * (base + (1.0 - base) * (1.0 - facing) ** 5))[:, None]
    back = 2.0 * facing[:, None] * normals - to_eye
    # Windows, shelves and people: a room is bright and dark in places.
    patches = (0.9 + 1.1 * noise(1.7 * back + 5.0)).clamp(min=0.1) * (0.15 + 0.85 * share[:, 3])
    horizon = ((back[:, 1] + 0.25) / 0.5).clamp(0.0, 1.0)[:, None]
    clear = 0.25 + 0.75 * (sharpness / 200.0).clamp(max=1.0)
    light = torch.lerp(lamps.ground, 2.2 * lamps.sky, horizon) * (clear * patches)[:, None]
    for lamp in (0, 1):
        direction, near = lamps.toward(points, lamp)
        halfway = (normals * unit(direction + to_eye)).sum(dim=-1).clamp(min=0.0)
        on = (normals * direction).sum(dim=-1).clamp(min=0.0) * near * share[:, lamp]
        light += lamps.color[lamp] * (0.09 * (sharpness + 8.0) * halfway**sharpness * on)[:, None]
    return mirrored * light * torch.lerp(torch.ones(3), 2.0 * albedo.clamp(max=0.5), metal[:, None])


def unit(vectors: Tensor) -> Tensor:
    """Vectors (..., 3) at a length of 1; zero stays zero."""
    length: Tensor = vectors.norm(dim=-1, keepdim=True)
    return vectors / length.clamp(min=1e-6)
