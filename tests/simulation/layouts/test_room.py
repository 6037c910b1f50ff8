"""The preset `room`, before and after physics."""

from __future__ import annotations

import pytest
import torch

from blockstab.boxes.box import checked
from blockstab.boxes.separation import separation
from blockstab.determinism.threads import one_thread
from blockstab.simulation.layouts.placing import Structure, lifted
from blockstab.simulation.layouts.room import REACH, STRUCTURES, arrange_room
from blockstab.simulation.physics.settling import settle


@pytest.mark.parametrize("structure", dict.fromkeys(STRUCTURES), ids=lambda s: s.__name__)
def test_no_two_bounding_boxes_overlap(structure: Structure, generator: torch.Generator) -> None:
    for _ in range(5):
        pile = lifted(structure(generator))
        boxes = checked(pile.boxes())
        assert boxes.corners()[..., 1].min() > 0
        first, second = torch.combinations(torch.arange(len(pile)), 2).unbind(dim=1)
        assert not (separation(boxes, first, second).gap < -1e-9).any()


def test_a_room_holds_some_eighty_things_most_of_them_small_and_comes_to_rest(
    generator: torch.Generator,
) -> None:
    pytest.importorskip("mujoco", reason="the extra `sim` is not installed")
    with one_thread():
        room = arrange_room(generator)
        assert 60 <= len(room) <= 95
        small = [float(solid.half_extent.max()) < 0.3 for solid in room.solids]
        assert sum(small) > 0.6 * len(small)
        assert float(room.boxes().corners()[..., [0, 2]].norm(dim=-1).max()) < REACH
        assert settle(room, REACH + 0.1) is not None
        assert settle(room) is None
