"""Share of the light in a room that reaches each point: shadows, dark corners, mirrored things."""

from __future__ import annotations

import math
from dataclasses import dataclass

import torch
from torch import Tensor

from blockstab.simulation.appearance.lighting import Lamps, unit
from blockstab.simulation.appearance.raycasting import NOTHING, RayCaster, Surfaces

_LAMP_RAYS, _SKY_RAYS, _MIRROR_RAYS = (12, 5), 14, 4  # from each point that is looked from
_SKY_REACH, _MIRROR_REACH = 0.25, 0.6  # metres; what is further off darkens no corner, and is not mirrored
# Steps whose multiples fill the unit square evenly (Roberts 2018, the R2 sequence).
_EVEN = torch.tensor([0.7548776662, 0.5698402910])


@dataclass(frozen=True)
class Openness:
    """Share of the light that reaches points on a grid of pixels, every second one in both directions.

    Args:
        seen: (h, w) what is in those pixels.
        share: (h, w, 4) float32, from 0 to 1: how much of the two lamps, of the sky and, in a rough mirror, of
            the room can be seen from there.
    """

    seen: Surfaces
    share: Tensor

    def at(self, seen: Surfaces, row: Tensor, column: Tensor) -> Tensor:
        """Shares (M, 4) at surfaces seen in the picture at `row` and `column`, pixels (M,).

        Taken from those of the four nearest points of the grid that lie on the same smooth surface.
        """
        height, width = self.share.shape[:2]
        y, x = (row / 2).clamp(0, height - 1), (column / 2).clamp(0, width - 1)
        grid = self.seen
        solid, share = grid.solid.flatten(), self.share.flatten(0, 1)
        points, normals = (v.to(torch.float32).flatten(0, 1) for v in (grid.points, grid.normals))
        total, weight = torch.zeros(len(row), 4), torch.zeros(len(row), 1)
        own_points, own_normals = seen.points.to(torch.float32), seen.normals.to(torch.float32)
        for down in (0, 1):
            for across in (0, 1):
                i = (y.long() + down).clamp(max=height - 1)
                j = (x.long() + across).clamp(max=width - 1)
                at = i * width + j
                off_plane = ((points[at] - own_points) * own_normals).sum(dim=-1).abs()
                bend = (normals[at] * own_normals).sum(dim=-1)
                alike = (solid[at] == seen.solid) & (off_plane < 0.006) & (bend > 0.7)
                near = (1 - (y - i).abs()).clamp(min=0) * (1 - (x - j).abs()).clamp(min=0)
                w = ((near + 1e-3) * (alike + 1e-4)).to(torch.float32)[:, None]
                total += w * share[at]
                weight += w
        return total / weight


def openness(seen: Surfaces, caster: RayCaster, lamps: Lamps, eye: Tensor) -> Openness:
    """Look from every second pixel of what `eye` (3,) has `seen` (H, W) to the lamps and around."""
    grid = seen[::2, ::2]
    points = grid.points.to(torch.float32).flatten(0, 1)
    normals = grid.normals.to(torch.float32).flatten(0, 1)
    start, shift = points + 1e-3 * normals, _interleaved(*grid.solid.shape)
    shares = []
    for lamp, rays in enumerate(_LAMP_RAYS):
        aim = lamps.position[lamp] + lamps.radius[lamp] * _ball(_even(shift, rays))
        shares.append(1.0 - caster.hidden_from(aim, start.expand_as(aim)).to(torch.float32).mean(dim=0))
    # Added to the normal, points of a sphere give directions distributed with the cosine to it.
    around = unit(normals + _ball(_even(shift, _SKY_RAYS)))
    glance = unit(points - eye.to(torch.float32))
    back = glance - 2.0 * (glance * normals).sum(dim=-1, keepdim=True) * normals
    back = unit(back + 0.15 * _ball(_even(shift, _MIRROR_RAYS)))
    for directions, reach in ((around, _SKY_REACH), (back, _MIRROR_REACH)):
        shaded = caster.shaded(start.expand_as(directions), directions, reach)
        shares.append(1.0 - shaded.to(torch.float32).mean(dim=0))
    share = torch.stack(shares, dim=-1).view(*grid.solid.shape, -1)
    return Openness(grid, _smoothed(_smoothed(share, grid, 1), grid, 2))


def _interleaved(height: int, width: int) -> Tensor:
    """Shifts (h w, 2) that differ between neighbours (Jimenez 2014, interleaved gradient noise)."""
    y, x = torch.meshgrid(torch.arange(height), torch.arange(width), indexing="ij")
    first = (52.9829189 * (0.06711056 * x + 0.00583715 * y).frac()).frac()
    second = (52.9829189 * (0.06711056 * (y + 47) + 0.00583715 * (x + 17)).frac()).frac()
    return torch.stack([first, second], dim=-1).flatten(0, 1)


def _even(shift: Tensor, rays: int) -> Tensor:
    """Points (rays, M, 2) of the unit square, evenly spread for every shift (M, 2)."""
    return (torch.arange(rays)[:, None, None] * _EVEN + shift).frac()


def _ball(square: Tensor) -> Tensor:
    """Directions (..., 3) on the unit sphere from points (..., 2) of the unit square."""
    height = 1.0 - 2.0 * square[..., 0]
    flat, angle = (1.0 - height * height).clamp(min=0.0).sqrt(), 2 * math.pi * square[..., 1]
    return torch.stack([flat * angle.cos(), height, flat * angle.sin()], dim=-1)


def _smoothed(share: Tensor, grid: Surfaces, step: int) -> Tensor:
    """Means over 3 x 3 neighbours, `step` pixels apart, on the same smooth surface."""
    normals = grid.normals.to(torch.float32)
    near = grid.depth.to(torch.float32)
    total: Tensor = share.clone()
    weight = torch.ones(*near.shape, 1)
    for down in (-step, 0, step):
        for across in (-step, 0, step):
            if down or across:
                moved = [v.roll((down, across), (0, 1)) for v in (grid.solid, normals, near, share)]
                alike = (moved[0] == grid.solid) & ((moved[1] * normals).sum(dim=-1) > 0.8)
                alike &= ((moved[2] - near).abs() < 0.02 * near) & (grid.solid != NOTHING)
                total += alike[..., None] * moved[3]
                weight += alike[..., None]
    return total / weight
