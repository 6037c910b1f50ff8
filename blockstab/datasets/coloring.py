"""What colour the camera sees: grained and printed blocks under one lamp."""

from __future__ import annotations

import math

import torch
from torch import Tensor

from blockstab.boxes.box import Boxes
from blockstab.datasets.raycasting import NOTHING, RayCaster, Surfaces

_WOOD = (0.76, 0.58, 0.38)
_VOID = 0.08  # how bright a pixel is that sees nothing
_WOOD_SHARE = 0.4
_PRINT_SHARE = 0.3  # of all faces


def paint(
    seen: Surfaces, boxes: Boxes, caster: RayCaster, furniture: int, generator: torch.Generator
) -> Tensor:
    """Colour what is seen.

    There are fewer paints than blocks, so that some neighbours look alike. Every block has a grain and a
    slightly different tone on each face; some faces carry a printed rectangle. One far lamp throws shadows;
    the image is blurred a little and noisy.

    Args:
        seen: what each of H x W pixels sees of `boxes`.
        boxes: the room, of which the first `furniture` are table, floor and walls.
        caster: rays against the same boxes.

    Returns:
        (H, W, 3) uint8, RGB.
    """
    color = _material(seen, boxes, furniture, generator) * _light(seen, caster, generator)[..., None]
    color = torch.where((seen.box == NOTHING)[..., None], _VOID, color)
    exposure = 0.85 + 0.3 * _draw(generator, 1)
    noise = 0.012 * torch.randn(color.shape, generator=generator, dtype=torch.float64)
    return (255.0 * (_blurred(exposure * color) + noise)).round().clamp(0, 255).to(torch.uint8)


def _material(seen: Surfaces, boxes: Boxes, furniture: int, generator: torch.Generator) -> Tensor:
    n = len(boxes)
    base = _base_colors(n, furniture, generator)
    tone = 1.0 + 0.06 * torch.randn(n, 6, generator=generator, dtype=torch.float64)
    box, face = seen.box.clamp(min=0), seen.face
    offset = seen.points - boxes.center[box]
    local = (offset[..., :, None] * boxes.rotation[box]).sum(dim=-2)
    color = base[box] * tone[box, face][..., None] * _grain(local, box, n, furniture, generator)[..., None]
    inside, ink = _print(local / boxes.half_extent[box], box, face, n, furniture, generator)
    return torch.where(inside[..., None], ink, color)


def _base_colors(n: int, furniture: int, generator: torch.Generator) -> Tensor:
    """One colour per box, (N, 3), drawn from a few paints."""
    paints = max(2, (n - furniture + 1) // 2)
    bright = 0.25 + 0.65 * _draw(generator, paints, 1)
    hue = _draw(generator, paints, 3)
    vivid = bright * hue / hue.amax(dim=1, keepdim=True)
    wood = (0.55 + 0.6 * _draw(generator, paints, 1)) * torch.tensor(_WOOD, dtype=torch.float64)
    choice = torch.where(_draw(generator, paints, 1) < _WOOD_SHARE, wood, vivid)
    blocks = choice[torch.randint(paints, (n - furniture,), generator=generator)]
    pale = 0.45 + 0.4 * _draw(generator, furniture, 1) + 0.08 * _draw(generator, furniture, 3)
    if float(_draw(generator, 1)) < 0.5:
        pale[0] = wood[0] * 0.9 + 0.1
    return torch.cat([pale, blocks])


def _grain(local: Tensor, box: Tensor, n: int, furniture: int, generator: torch.Generator) -> Tensor:
    """Brightness (H, W) of wavy stripes, which differ in direction, width and contrast from box to box."""
    waves = torch.randn(2, n, 3, generator=generator, dtype=torch.float64)
    waves = waves / waves.norm(dim=-1, keepdim=True)
    length = 0.008 + 0.03 * _draw(generator, n, 1)  # metres from stripe to stripe
    across, along = 2 * math.pi * waves[0] / length, 2 * math.pi * waves[1] / 0.15
    contrast = 0.12 * _draw(generator, n)
    contrast[:furniture] *= 0.3
    bend = 1.5 * ((local * along[box]).sum(dim=-1)).sin()
    stripes: Tensor = ((local * across[box]).sum(dim=-1) + bend).sin()
    return 1.0 + contrast[box] * stripes


def _print(
    relative: Tensor, box: Tensor, face: Tensor, n: int, furniture: int, generator: torch.Generator
) -> tuple[Tensor, Tensor]:
    """Where a printed rectangle is seen, (H, W) bool, and its colour, (H, W, 3).

    Args:
        relative: (H, W, 3) coordinates along the axes of the box, in half extents.
    """
    middle = 0.8 * _draw(generator, n, 6, 3) - 0.4
    half = 0.2 + 0.4 * _draw(generator, n, 6, 3)
    ink = 0.1 + 0.85 * _draw(generator, n, 6, 3)
    printed = _draw(generator, n, 6) < _PRINT_SHARE
    printed[:furniture] = False
    # A face is flat along its own axis, so only the other two decide.
    axis = torch.arange(3) == (face // 2)[..., None]
    inside = ((relative - middle[box, face]).abs() < half[box, face]) | axis
    return inside.all(dim=-1) & printed[box, face], ink[box, face]


def _light(seen: Surfaces, caster: RayCaster, generator: torch.Generator) -> Tensor:
    """Brightness (H, W) under a far lamp: Lambert's law, shadows, and an even rest."""
    share = _draw(generator, 3)
    elevation, azimuth, ambient = 0.7 + 0.6 * share[0], 2 * math.pi * share[1], 0.4 + 0.2 * share[2]
    flat = elevation.cos()
    lamp = torch.stack([flat * azimuth.cos(), elevation.sin(), flat * azimuth.sin()])
    facing = (seen.normals * lamp).sum(dim=-1).clamp(min=0.0)
    # Shadows are not black: a room's walls send light into them.
    shadow = torch.where(caster.shaded_from(lamp, seen.points), 0.3, 1.0)
    return ambient + (1.0 - ambient) * facing * shadow


def _blurred(color: Tensor) -> Tensor:
    """Smoothed by 1 2 1 along rows and columns."""
    for dim in (0, 1):
        first, last = color.narrow(dim, 0, 1), color.narrow(dim, -1, 1)
        wide = torch.cat([first, color, last], dim=dim)
        size = color.shape[dim]
        color = (wide.narrow(dim, 0, size) + 2.0 * color + wide.narrow(dim, 2, size)) / 4.0
    return color


def _draw(generator: torch.Generator, *shape: int) -> Tensor:
    return torch.rand(*shape, generator=generator, dtype=torch.float64)
