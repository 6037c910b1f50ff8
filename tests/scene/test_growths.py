"""Lengths that are tried are those that were hidden, or reach what is beneath; slabs become bodies first."""

from __future__ import annotations

import pytest
import torch

from blockstab.boxes.box import Boxes
from blockstab.scene.growths import Growth, cost, double, lengths, single
from blockstab.testing.worlds import Block
from tests.stability.seen_from_afar import looked_at, situation

RIGHT, DOWN, BACK = 0, 3, 5


def reach_of(**faces: float) -> torch.Tensor:
    row = torch.zeros(6, dtype=torch.float64)
    for name, most in faces.items():
        row[{"right": RIGHT, "down": DOWN, "back": BACK}[name]] = most
    return row


def test_a_face_goes_on_by_steps_of_what_was_hidden():
    found = lengths(situation(*looked_at(Block(0, 0, 0.2, 0.2))), 0, reach_of(back=0.03))
    assert found[BACK].tolist() == pytest.approx([0.01, 0.02, 0.03])
    assert [len(some) for face, some in enumerate(found) if face != BACK] == [0] * 5


def test_a_box_becomes_at_most_twice_as_long_as_its_greatest_edge():
    found = lengths(situation(*looked_at(Block(0, 0, 0.05, 0.05, d=0.05))), 0, reach_of(back=0.4))
    assert float(found[BACK].max()) == pytest.approx(0.05)


def test_downward_a_box_goes_to_what_is_beneath_and_to_the_ground():
    blocks = (Block(0, 0.3, 0.1, 0.1), Block(0.5, 0, 0.1, 0.1))
    found = lengths(situation(*looked_at(*blocks)), 0, reach_of(down=0.4))
    assert found[DOWN].tolist() == pytest.approx([0.2, 0.3])


def test_options_are_all_lengths_of_one_face_and_a_few_of_every_two():
    steps = torch.arange(1, 11, dtype=torch.float64) / 100
    growths = [Growth(0, BACK, steps), Growth(1, DOWN, steps[:2])]
    one, two = single(growths, 3), double(growths, 3)
    assert one.shape == (12, 3, 6)
    assert two.shape == (10, 3, 6)
    assert bool(((one > 0).sum(dim=(1, 2)) == 1).all())
    assert bool(((two > 0).sum(dim=(1, 2)) == 2).all())
    assert single([], 3).shape == double([], 3).shape == (0, 3, 6)


def test_it_is_likelier_that_a_slab_is_a_body_than_that_a_body_is_longer():
    slab = Boxes(
        torch.zeros(1, 3, dtype=torch.float64),
        torch.eye(3, dtype=torch.float64)[None],
        torch.tensor([[0.05, 0.10, 0.005]], dtype=torch.float64),
    )
    added = torch.zeros(3, 1, 6, dtype=torch.float64)
    added[0, 0, 5] = added[1, 0, 1] = added[2, 0, 3] = (
        0.05  # thicker, wider, longer than it was along any axis
    )
    assert cost(slab, added).tolist() == pytest.approx([0.025, 0.05, 0.1])
