"""Boxes that nearly touch are set down exactly; nothing else moves."""

from __future__ import annotations

import pytest
import torch

from blockstab.boxes.separation import separation
from blockstab.output.worlds.settled import overlapping, settled
from blockstab.testing import worlds
from blockstab.testing.worlds import Block
from tests.output.worlds.arrangements import arranged


@pytest.mark.parametrize("off", [-0.004, -0.001, 0.0, 0.003])
def test_a_stack_that_is_off_touches_exactly(off):
    asked = arranged(Block(0, off / 2, 0.2, 0.1), Block(0, 0.1 + off, 0.2, 0.1))
    found = settled(asked).boxes
    assert float(found.corners()[0, :, 1].amin()) == pytest.approx(0.0, abs=1e-12)
    apart = separation(found, torch.tensor([0]), torch.tensor([1]))
    assert float(apart.gap[0]) == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize("blocks", [worlds.STACK, worlds.COUNTERWEIGHT, worlds.BRIDGE])
def test_exact_boxes_stay_where_they_are(blocks):
    asked = arranged(*blocks)
    assert torch.allclose(settled(asked).boxes.center, asked.boxes.center, atol=1e-12)


def test_what_floats_and_what_is_background_stays_where_it_is():
    asked = arranged(Block(0, 0.5, 0.1, 0.1), Block(2, 0.002, 0.1, 0.1, fixed=True))
    assert torch.equal(settled(asked).boxes.center, asked.boxes.center)


def test_pairs_overlap_if_they_do_so_by_more_than_is_allowed():
    asked = arranged(Block(0, 0, 0.1, 0.1), Block(0.098, 0, 0.1, 0.1), Block(1, 0, 0.1, 0.1))
    assert overlapping(asked, 0.001) == [(0, 1)]
    assert overlapping(asked, 0.003) == []
