"""The colour and the gloss of every point of a room, in linear light."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import torch
from torch import Tensor

from blockstab.simulation.appearance.finish import Grain, Look
from blockstab.simulation.appearance.lettering import Sheet
from blockstab.simulation.appearance.looks import draw_look, draw_paints
from blockstab.simulation.appearance.meshes import Patch
from blockstab.simulation.appearance.noise import SolidNoise, rings
from blockstab.simulation.appearance.raycasting import Surfaces
from blockstab.simulation.physics.solids import Pile

_DENSITY = torch.tensor([0.75, 1.0, 1.3])  # grain darkens blue more than red, as in wood


@dataclass(frozen=True)
class Materials:
    """Materials of N solids with P patches in all.

    Args:
        texels: (K, 3) float32 linear RGB, the prints of all patches, row by row from the top left.
        print: (P, 5) float32: where a patch's print starts, its width and height in texels, and in metres.
        finish: (P, 3) float32 gloss, sharpness, metal.
        grain: (N, 7) float32, as in `Grain`.
        along: (N, 3) int64 axes of each solid, the longest first.
        first_patch: (N,) int64, where its patches start.
        noise: fills all solids.
        offset: (N, 3) float32 cells, so that no two solids are cut from the same place.
    """

    texels: Tensor
    print: Tensor
    finish: Tensor
    grain: Tensor
    along: Tensor
    first_patch: Tensor
    noise: SolidNoise
    offset: Tensor

    def patch(self, seen: Surfaces) -> Tensor:
        """The number among all P patches of the points seen, (M,)."""
        return self.first_patch[seen.solid] + seen.patch

    def albedo(self, seen: Surfaces, local: Tensor) -> Tensor:
        """Linear RGB (M, 3) of points seen on solids, whose places in the solid's frame are `local` (M, 3)."""
        return self._printed(self.print[self.patch(seen)], seen.uv) * self._grained(seen.solid, local)

    def _printed(self, sheet: Tensor, uv: Tensor) -> Tensor:
        """Between the four nearest texels; beyond its end a print starts again."""
        start, width, height = sheet[:, :3].long().unbind(dim=1)
        x = uv[:, 0] / sheet[:, 3] * width - 0.5
        y = (1.0 - uv[:, 1] / sheet[:, 4]) * height - 0.5
        left, top = x.floor(), y.floor()
        across, down = (x - left)[:, None], (y - top)[:, None]
        columns = [(left.long() + k).remainder(width) for k in (0, 1)]
        rows = [start + (top.long() + k).remainder(height) * width for k in (0, 1)]
        upper, lower = (
            torch.lerp(self.texels[row + columns[0]], self.texels[row + columns[1]], across) for row in rows
        )
        return torch.lerp(upper, lower, down)

    def _grained(self, solid: Tensor, local: Tensor) -> Tensor:
        grain = dict(zip(Grain._fields, self.grain[solid].unbind(dim=1), strict=True))
        offset = self.offset[solid]
        broad = self.noise(local / grain["spot"][:, None] + offset)
        fine = self.noise(3.1 * local / grain["spot"][:, None] + 2.0 * offset)
        # No tree grows straight: the fibres wander by a few of their own thickness.
        wander = torch.zeros_like(local)
        wander[:, 1:] = 2.5 * (grain["thread"] * broad)[:, None]
        sorted_local = local.gather(1, self.along[solid]) + wander
        stretch = torch.tensor([0.05, 1.0, 1.0])
        fibre = self.noise(sorted_local * stretch / grain["thread"][:, None] + offset)
        fibre += self.noise(sorted_local * stretch / (4.3 * grain["thread"][:, None]) - offset)
        warp = self.noise(sorted_local * stretch / (4.0 * grain["spacing"][:, None]) + offset)
        specks = (self.noise(local / 0.007 + offset) - 0.35).clamp(min=0.0)
        density = grain["rings"] * rings(sorted_local, grain["spacing"], 0.9 * warp) + grain["fibre"] * fibre
        density += grain["mottle"] * (0.7 * broad + 0.4 * fine) + grain["speckle"] * specks
        return (-density[:, None] * _DENSITY).exp()


def draw_materials(
    room: Pile, patches: Sequence[tuple[Patch, ...]], things: int, variety: float, generator: torch.Generator
) -> Materials:
    """Make up every solid of a room.

    Args:
        patches: of each solid.
        things: how many of them, the last ones, are no furniture.
        variety: 0 for plain colours, 1 for full printing and grain.
    """
    paints = draw_paints(things, generator)
    base = int(torch.randint(2**40, (), generator=generator))
    noise = SolidNoise(generator)
    looks = []
    for number, (solid, own) in enumerate(zip(room.solids, patches, strict=True)):
        # Products count from far above the solids, so that no two seeds are equal.
        key = number if solid.product is None else 10_000 + solid.product
        looks.append(draw_look(solid, own, paints, torch.Generator().manual_seed(base + key)))
    prints, where = _laid_out(looks, variety)
    counts = torch.tensor([len(own) for own in patches])
    strength = torch.tensor([1, 0, 1, 0, 1, 0, 1], dtype=torch.bool)
    grain = torch.tensor([look.grain for look in looks])
    return Materials(
        prints,
        where,
        torch.tensor([finish for look in looks for finish in look.finishes]),
        torch.where(strength, variety * grain, grain),
        torch.stack([solid.half_extent.argsort(descending=True) for solid in room.solids]),
        counts.cumsum(dim=0) - counts,
        noise,
        64.0 * torch.rand(len(room), 3, generator=generator),
    )


def linear(color: Tensor) -> Tensor:
    """Linear light from sRGB, both 0 to 1 (IEC 61966-2-1)."""
    return torch.where(color <= 0.04045, color / 12.92, ((color + 0.055) / 1.055) ** 2.4)


def _laid_out(looks: Sequence[Look], variety: float) -> tuple[Tensor, Tensor]:
    """All prints in one row of texels (K, 3), and where each is, (P, 5)."""
    table = linear(torch.arange(256) / 255.0)
    prints, rows, start = [], [], 0
    for look in looks:
        plain = table[torch.tensor(look.plain)]
        for sheet in look.sheets:
            texels = table[_reduced(sheet)]
            height, width = texels.shape[:2]
            prints.append(torch.lerp(plain, texels.flatten(0, 1), variety))
            rows.append([start, width, height, *sheet.extent])
            start += width * height
    return torch.cat(prints), torch.tensor(rows)


def _reduced(sheet: Sheet) -> Tensor:
    """A sheet at half its resolution, (h, w, 3) int64."""
    return torch.from_numpy(np.array(sheet.image.reduce(2))).long()
