"""Scenes of one image beside each other, so that what is asked of each is answered for all of them at once."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import accumulate

import torch

from blockstab.boxes.box import concatenate
from blockstab.scene.islands import joined
from blockstab.scene.types import Pairs, Scene
from blockstab.segments.segmentation import Segmentation
from blockstab.stability.balance import concatenate as concatenate_balances


def beside(scenes: Sequence[Scene]) -> Scene:
    """Several scenes as one, whose segments follow each other and have nothing to do with those of another.

    Pairs, supports and verdicts are those of the scenes. Its segmentation is no partition: a segment of two scenes is
    there twice.

    Args:
        scenes: of one image; at least one.
    """
    sizes = list(map(len, scenes))
    starts = list(accumulate(sizes, initial=0))[:-1]
    names = [range(start, start + size) for start, size in zip(starts, sizes, strict=True)]
    pairs = [scene.pairs for scene in scenes]
    shift = torch.tensor(starts).repeat_interleave(torch.tensor([len(some.first) for some in pairs]))
    return Scene(
        segmentation=Segmentation(tuple(s for scene in scenes for s in scene.segmentation.segments)),
        ground=scenes[0].ground,
        pixel_count=torch.cat([scene.pixel_count for scene in scenes]),
        point_count=torch.cat([scene.point_count for scene in scenes]),
        background=torch.cat([scene.background for scene in scenes]),
        boxes=concatenate([scene.boxes for scene in scenes]),
        fit_mean=torch.cat([scene.fit_mean for scene in scenes]),
        fit_variance=torch.cat([scene.fit_variance for scene in scenes]),
        visible_share=torch.cat([scene.visible_share for scene in scenes]),
        pairs=Pairs(
            torch.cat([some.first for some in pairs]) + shift,
            torch.cat([some.second for some in pairs]) + shift,
            torch.cat([some.gap for some in pairs]),
            torch.cat([some.direction for some in pairs]),
            torch.cat([some.neighbours for some in pairs]),
        ),
        candidates=joined([scene.candidates for scene in scenes], names),
        supports=joined([scene.supports for scene in scenes], names),
        balance=concatenate_balances([scene.balance for scene in scenes]),
    )
