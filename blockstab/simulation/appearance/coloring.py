"""Colours that the camera sees: made-up things under lamps, through a lens."""

from __future__ import annotations

import torch
from torch import Tensor

from blockstab.simulation.appearance.lens import develop
from blockstab.simulation.appearance.lighting import Lamps, draw_lamps, gloss, lit, unit
from blockstab.simulation.appearance.materials import Materials, draw_materials
from blockstab.simulation.appearance.openness import Openness, openness
from blockstab.simulation.appearance.raycasting import NOTHING, RayCaster, Surfaces
from blockstab.simulation.appearance.viewpoint import Viewpoint
from blockstab.simulation.physics.solids import Pile, concatenate

_VOID = 0.03  # how bright a pixel is that sees nothing
_BEVEL = 0.003  # metres from the edge of a box at which its faces begin to bend
# Where in a pixel the finer rays go, pixels from its middle: three on a triangle.
_FINER = torch.tensor([[-0.32, 0.0], [0.16, -0.3], [0.16, 0.3]], dtype=torch.float64)


def paint(
    seen: Surfaces,
    view: Viewpoint,
    room: Pile,
    pile: Pile,
    caster: RayCaster,
    variety: float,
    generator: torch.Generator,
) -> Tensor:
    """Colour what is seen.

    Pixels on objects and at edges are the mean of three finer rays; floor, walls and table need but one.

    Args:
        seen: what each of H x W pixels sees of `room` and `pile`, in this order.
        caster: rays against the same solids.
        variety: from 0, plain colours under one light, to 1, the full range of materials and lights.

    Returns:
        (H, W, 3) uint8, RGB.
    """
    solids = concatenate([room, pile])
    materials = draw_materials(solids, caster.patches, len(pile), variety, generator)
    lamps = draw_lamps(view, pile.center.mean(dim=0), variety, generator)
    open_ = openness(seen, caster, lamps, view.center)
    scene = _Scene(solids, view, materials, lamps, open_)
    row, column = torch.meshgrid(*(torch.arange(n, dtype=torch.float64) for n in view.size), indexing="ij")
    fine = _detailed(seen, len(room))
    light = torch.empty(*view.size, 3)
    light[~fine] = scene.light(seen[~fine], row[~fine], column[~fine])
    rows, columns = (at[fine][:, None] + _FINER[:, k] for k, at in enumerate((row, column)))
    finer = caster.first_hit(view.center, view.rays_at(rows, columns).flatten(0, 1))
    light[fine] = scene.light(finer, rows.flatten(), columns.flatten()).view(*rows.shape, 3).mean(dim=1)
    return develop(light, variety, generator)


class _Scene:
    """Everything that decides the light of a point of the picture."""

    def __init__(
        self, solids: Pile, view: Viewpoint, materials: Materials, lamps: Lamps, openness: Openness
    ) -> None:
        self._boxes, self._view = solids.boxes(), view
        self._materials, self._lamps, self._openness = materials, lamps, openness
        self._angular = torch.tensor([all(p.form == "box" for p in s.parts) for s in solids.solids])

    def light(self, seen: Surfaces, row: Tensor, column: Tensor) -> Tensor:
        """Linear RGB (M, 3) of what is seen at these places of the picture, pixels (M,)."""
        light = torch.full((len(row), 3), _VOID)
        hit = seen.solid != NOTHING
        seen, row, column = seen[hit], row[hit], column[hit]
        offset = (seen.points - self._boxes.center[seen.solid])[:, None]
        local = (offset @ self._boxes.rotation[seen.solid])[:, 0]
        normals, points = self._bent(seen, local), seen.points.to(torch.float32)
        share = self._openness.at(seen, row, column)
        albedo = self._materials.albedo(seen, local.to(torch.float32))
        finish = self._materials.finish[self._materials.patch(seen)]
        eye = self._view.center.to(torch.float32)
        matt = (1.0 - 0.8 * finish[:, 2:]) * lit(albedo, normals, points, share, self._lamps)
        shine = gloss(albedo, finish, normals, points, eye, share, self._lamps, self._materials.noise)
        light[hit] = matt + shine
        return light

    def _bent(self, seen: Surfaces, local: Tensor) -> Tensor:
        """Normals (M, 3) float32, bent outward near the edges of what is made of boxes."""
        half, turn = self._boxes.half_extent[seen.solid], self._boxes.rotation[seen.solid]
        into = ((local.abs() - half) / _BEVEL + 1.0).clamp(0.0, 1.0) ** 2 * local.sign()
        bend = (turn @ into[..., None])[..., 0] * self._angular[seen.solid][:, None]
        # Along its own normal every point of a face is at the end: that changes no direction.
        normals = (seen.normals + 0.5 * bend).to(torch.float32)
        return unit(normals)


def _detailed(seen: Surfaces, furniture: int) -> Tensor:
    """Pixels (H, W) that see an object, or another patch than a neighbour does."""
    patch = torch.where(seen.solid == NOTHING, NOTHING, 64 * seen.solid + seen.patch)
    fine = seen.solid >= furniture
    for dim in (0, 1):
        n = patch.shape[dim]
        edge = patch.narrow(dim, 1, n - 1) != patch.narrow(dim, 0, n - 1)
        fine.narrow(dim, 1, n - 1).logical_or_(edge)
        fine.narrow(dim, 0, n - 1).logical_or_(edge)
    return fine
