"""A situation asked again with other boxes in place says what it would say of them by themselves."""

from __future__ import annotations

from dataclasses import replace

import pytest
import torch

from blockstab.geometry.convex_hulls import hull
from blockstab.stability.situation import Unseen
from blockstab.stability.support import GROUND
from blockstab.stability.unseen import grown
from blockstab.testing import worlds
from blockstab.testing.worlds import Block
from tests.stability.seen_from_afar import looked_at, situation


@pytest.mark.parametrize("blocks", [worlds.STACK, worlds.BRIDGE, worlds.COUNTERWEIGHT, worlds.overhang(0.02)])
def test_many_at_once_are_judged_as_each_by_itself(blocks, generator):
    asked = situation(*looked_at(*blocks))
    added = torch.rand(400, len(blocks), 6, generator=generator, dtype=torch.float64) * 0.05
    stands = asked.standing_with(added)
    for some, row in list(zip(added, stands, strict=True))[::23]:
        alone = replace(asked, boxes=grown(asked.boxes, some))
        assert torch.equal(alone.verdicts().balance.stable, row)


def test_what_is_carried_unseen_stands():
    asked = situation(*looked_at(Block(0, 0.3, 0.1, 0.1)))
    assert not bool(asked.verdicts().balance.stable)
    shadow = asked.candidates().area  # nothing
    assert len(shadow) == 0
    square = looked_at(Block(0, 0.3, 0.1, 0.1))[0].corners()[:, [0, 4, 5, 1]][..., [0, 2]]
    area = hull(square, torch.ones(1, 4, dtype=torch.bool))
    carried = replace(asked, unseen=Unseen(torch.tensor([0]), area))
    assert bool(carried.verdicts().balance.stable)
    assert carried.candidates().supporter.tolist() == [GROUND]
    assert bool(carried.standing_with(torch.zeros(3, 1, 6, dtype=torch.float64)).all())


def test_a_part_keeps_what_is_its_own():
    blocks = (*worlds.STACK, Block(2, 0.5, 0.1, 0.1))
    asked = situation(*looked_at(*blocks))
    whole = asked.verdicts().balance.stable
    for members in ([0, 1], [2], [0, 1, 2]):
        part = asked.part(torch.tensor(members))
        assert torch.equal(part.verdicts().balance.stable, whole[members])
