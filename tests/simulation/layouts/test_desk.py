"""The preset `desk`, before and after physics."""

from __future__ import annotations

import pytest
import torch

from blockstab.boxes.box import checked
from blockstab.boxes.separation import separation
from blockstab.simulation.layouts.desk import STRUCTURES, arrange_desk
from blockstab.simulation.layouts.placing import Structure, lifted
from blockstab.simulation.physics.settling import settle


@pytest.mark.parametrize("structure", dict.fromkeys(STRUCTURES), ids=lambda s: s.__name__)
def test_no_two_bounding_boxes_overlap(structure: Structure, generator: torch.Generator) -> None:
    for _ in range(10):
        pile = lifted(structure(generator))
        boxes = checked(pile.boxes())
        assert boxes.corners()[..., 1].min() > 0
        first, second = torch.combinations(torch.arange(len(pile)), 2).unbind(dim=1)
        assert not (separation(boxes, first, second).gap < -1e-9).any()


def test_most_of_what_lies_on_a_desk_is_flat_and_some_of_it_swallows_light(
    generator: torch.Generator,
) -> None:
    solids = [solid for _ in range(20) for solid in arrange_desk(generator).solids]
    low = [float(solid.half_extent.min()) < 0.02 for solid in solids]
    faint = [min(part.echo for part in solid.parts) < 0.5 for solid in solids]
    assert sum(low) > 0.5 * len(solids)
    assert 0.1 < sum(faint) / len(solids) < 0.5


def test_most_desks_come_to_rest() -> None:
    pytest.importorskip("mujoco", reason="the extra `sim` is not installed")
    assert (
        sum(settle(arrange_desk(torch.Generator().manual_seed(seed))) is not None for seed in range(8)) >= 5
    )
