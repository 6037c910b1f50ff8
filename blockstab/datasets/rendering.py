"""The picture that a Kinect takes of a pile of boxes in a furnished room."""

from __future__ import annotations

import torch

from blockstab.boxes.box import Boxes, concatenate
from blockstab.datasets.coloring import paint
from blockstab.datasets.raycasting import NOTHING, RayCaster
from blockstab.datasets.sensor import BASELINE, measure
from blockstab.datasets.viewpoint import View, furnish
from blockstab.rgbd.frame import Frame

TABLE = 1  # label id of the table; the objects follow, then floor and wall


def photograph(name: str, pile: Boxes, view: View, generator: torch.Generator) -> Frame:
    """Furnish the room and take its picture.

    Args:
        name: of the frame.
        pile: N boxes in the table frame; object i of them gets the label id `i + 2`.

    Convention:
        A label is that of the surface exactly in the middle of the pixel, and 0 where depth is missing. At
        edges, where depth frays, a pixel may carry the label of one surface and the depth of another.
    """
    furniture = furnish(generator, view)
    room = concatenate([furniture, pile])
    caster = RayCaster(room)
    rays = view.rays()
    seen = caster.first_hit(view.center, rays)
    facing = -(rays * seen.normals).sum(dim=-1) / rays.norm(dim=-1)
    projector = view.center + BASELINE * view.camera_from_table[0]
    lit = ~caster.hidden_from(projector, seen.points)
    depth = measure(seen.depth, facing.clamp(-1.0, 1.0).arccos(), lit, generator)
    color = paint(seen, room, caster, len(furniture), generator)
    objects = torch.arange(len(pile)) + TABLE + 1
    behind = torch.arange(len(furniture) - 1) + TABLE + 1 + len(pile)
    ids = torch.cat([torch.tensor([TABLE]), behind, objects])
    label = torch.where((seen.box != NOTHING) & (depth > 0), ids[seen.box.clamp(min=0)], 0)
    background = (TABLE, *behind.tolist())
    return Frame(name, color, depth, view.camera, label, background, view.up_camera())
