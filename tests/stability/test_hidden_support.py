"""Something unseen carries a box only where it can have been hidden, and only where it would do."""

from __future__ import annotations

import torch

from blockstab.stability.hidden_support import HiddenSupport, areas_of, hidden_support
from blockstab.testing.worlds import Block
from tests.stability.seen_from_afar import EYE, hidden_by, looked_at, situation

PLATE = Block(0, 0.2, 0.3, 0.02, z=-0.4, d=0.2)
SCREEN = Block(0, 0, 0.8, 0.5, z=-0.1)


def found(*blocks: Block, hiding: tuple[Block, ...], shift: float = 0.0) -> HiddenSupport | None:
    boxes, movable = looked_at(*blocks)
    asked = situation(boxes, movable)
    held = asked.candidates().area[asked.candidates().supported == 0]
    center = boxes.center[0] + torch.tensor([shift, 0.0, 0.0], dtype=torch.float64)
    return hidden_support(boxes, 0, hidden_by(looked_at(*hiding)[0]), held, center, -float(EYE[1]))


def test_a_plate_behind_a_screen_may_stand_on_something_unseen():
    support = found(PLATE, hiding=(PLATE, SCREEN))
    assert support is not None
    assert abs(support.top - (0.2 - float(EYE[1]))) < 1e-9
    assert abs(support.bottom + float(EYE[1])) < 1e-9
    assert float(support.area[:, 0].abs().max()) < 0.15


def test_a_plate_in_plain_view_stands_on_nothing():
    assert found(PLATE, hiding=(PLATE,)) is None


def test_what_is_hidden_must_lie_under_the_weight():
    assert found(PLATE, hiding=(PLATE, SCREEN), shift=0.2) is None


def test_what_is_unseen_stands_on_the_thing_beneath():
    support = found(PLATE, Block(0, 0, 0.6, 0.1, z=-0.4, d=0.5), hiding=(PLATE, SCREEN))
    assert support is not None
    assert abs(support.bottom - (0.1 - float(EYE[1]))) < 1e-9


def test_areas_are_those_of_the_supports():
    support = found(PLATE, hiding=(PLATE, SCREEN))
    assert support is not None
    areas = areas_of([support, support])
    assert areas.count.tolist() == [len(support.area)] * 2
