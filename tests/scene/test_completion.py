"""Boxes are completed where they were hidden, so that the scene stands; and only so far, and only there."""

from __future__ import annotations

import pytest
import torch

from blockstab.boxes.box import Boxes
from blockstab.scene.completion import Completion, Verdict, completed
from blockstab.testing import worlds
from blockstab.testing.worlds import Block
from tests.stability.seen_from_afar import hidden_by, looked_at, situation

UP, DOWN, FRONT, BACK = 2, 3, 4, 5


def concluded(seen: tuple[Block, ...], true: tuple[Block, ...]) -> tuple[Boxes, Completion]:
    """What is made of blocks as they were seen, where the camera saw the true ones."""
    boxes, movable = looked_at(*seen)
    return boxes, completed(situation(boxes, movable), hidden_by(looked_at(*true)[0]))


BEFORE = Block(0, 0, 0.4, 0.25, z=-0.1)
BEHIND = Block(0, 0, 0.1, 0.35, z=-0.3)
ITS_TOP = Block(0, 0.2, 0.1, 0.15, z=-0.3)


def test_a_box_behind_another_goes_down_to_the_ground():
    _, found = concluded((BEFORE, ITS_TOP), (BEFORE, BEHIND))
    assert found.verdict == (Verdict.STABLE, Verdict.COMPLETED)
    assert float(found.added[1, DOWN]) == pytest.approx(0.2, abs=1e-9)
    assert int((found.added > 0).sum()) == 1


def test_a_floating_box_with_nothing_hidden_beneath_it_falls():
    floating = (Block(0, 0.3, 0.1, 0.1),)
    boxes, found = concluded(floating, floating)
    assert found.verdict == (Verdict.UNSTABLE,)
    assert torch.equal(found.situation.boxes.center, boxes.center)


def test_two_fronts_are_completed_backward_until_one_carries_the_other():
    true = (Block(0, 0.3, 0.3, 0.2, d=0.2, fixed=True), Block(0, 0.5, 0.3, 0.2, z=-0.05, d=0.3))
    # Only the two fronts were seen, a centimetre thick, and the upper one lies a little further back.
    front = (Block(0, 0.3, 0.3, 0.2, z=0.095, d=0.01), Block(0, 0.5, 0.3, 0.2, z=0.05, d=0.01))
    boxes, movable = looked_at(Block(0, 0, 1.0, 0.3, fixed=True), *front)
    found = completed(situation(boxes, movable), hidden_by(looked_at(*true)[0]))
    assert found.verdict[1:] == (Verdict.COMPLETED, Verdict.STABLE)
    assert bool((found.added[1:, BACK] >= 0).all())
    assert float(found.added[:, FRONT].abs().max()) == 0.0


@pytest.mark.parametrize("blocks", [worlds.STACK, worlds.ONE_BLOCK, worlds.COUNTERWEIGHT, worlds.TENT])
def test_what_stands_as_it_was_seen_stays_as_it_was_seen(blocks):
    boxes, found = concluded(blocks, blocks)
    assert set(found.verdict) == {Verdict.STABLE}
    assert torch.equal(found.situation.boxes.center, boxes.center)
    assert torch.equal(found.situation.boxes.half_extent, boxes.half_extent)


def test_faces_that_were_seen_never_move():
    seen = (BEFORE, ITS_TOP, Block(0.6, 0.2, 0.1, 0.1))
    boxes, found = concluded(seen, (BEFORE, BEHIND, seen[2]))
    outward = ((found.situation.boxes.face_centers() - boxes.face_centers()) * boxes.face_normals()).sum(
        dim=-1
    )
    assert float(outward[:, [UP, FRONT]].abs().max()) < 1e-12
    assert bool((outward > -1e-12).all())


def test_background_is_neither_completed_nor_judged():
    _, found = concluded((Block(0, 0, 1, 0.1, fixed=True),), (Block(0, 0, 1, 0.1, fixed=True),))
    assert found.verdict == (Verdict.BACKGROUND,)
