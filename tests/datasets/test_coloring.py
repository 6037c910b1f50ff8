"""Colour is lit and grained, and no guide to what is an object."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import torch

from blockstab.boxes.box import Boxes, concatenate
from blockstab.datasets.coloring import paint
from blockstab.datasets.raycasting import NOTHING, RayCaster, Surfaces
from blockstab.datasets.viewpoint import draw_view, furnish

Upright = Callable[[Sequence[tuple[float, ...]]], Boxes]


def picture(upright: Upright, seed: int) -> tuple[Surfaces, torch.Tensor]:
    generator = torch.Generator().manual_seed(seed)
    pile = upright([(0.15 * x, 0.05, 0.15 * z, 0.05, 0.05, 0.05) for x in (-1, 0, 1) for z in (-1, 0, 1)])
    view = draw_view(generator, pile)
    furniture = furnish(generator, view)
    room = concatenate([furniture, pile])
    caster = RayCaster(room)
    seen = caster.first_hit(view.center, view.rays())
    return seen, paint(seen, room, caster, len(furniture), generator)


def test_every_surface_is_textured_and_what_is_not_seen_is_dark(upright: Upright) -> None:
    seen, color = picture(upright, 1)
    assert color.shape == (480, 640, 3)
    assert color.dtype == torch.uint8
    for box in seen.box.unique().tolist():
        values = color[seen.box == box].double()
        if box == NOTHING:
            assert values.mean() < 40
        elif len(values) > 500:
            assert values.std(dim=0).min() > 2


def test_nine_blocks_have_at_most_five_paints(upright: Upright) -> None:
    seen, color = picture(upright, 2)
    hues = []
    for box in seen.box.unique().tolist()[-9:]:
        face = seen.face[seen.box == box].mode().values
        values = color[(seen.box == box) & (seen.face == face)].double().median(dim=0).values
        hues.append(values / values.norm())
    apart = torch.cdist(torch.stack(hues), torch.stack(hues)) > 0.05
    # Greedily counted groups of one hue.
    groups = sum(1 for i in range(len(hues)) if bool(apart[i, :i].all()))
    assert groups <= 6
