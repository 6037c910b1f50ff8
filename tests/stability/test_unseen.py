"""Faces go on where the camera could not look, and nowhere else."""

from __future__ import annotations

import torch

from blockstab.stability.unseen import MOST_M, STEP_M, grown, unseen_reach
from blockstab.testing.worlds import Block
from tests.stability.seen_from_afar import EYE, hidden_by, looked_at

RIGHT, LEFT, UP, DOWN, FRONT, BACK = range(6)  # the camera stands on the side of +z
GROUND = -float(EYE[1])


def reach_of(*blocks: Block, hiding: tuple[Block, ...] | None = None) -> list[float]:
    boxes, movable = looked_at(*blocks)
    true = boxes if hiding is None else looked_at(*hiding)[0]
    return unseen_reach(boxes, torch.tensor([0]), hidden_by(true), movable, GROUND)[0].tolist()


def test_a_face_that_was_seen_stays_where_it_is():
    reach = reach_of(Block(0, 0, 0.1, 0.3))
    assert [reach[face] for face in (RIGHT, LEFT, UP, FRONT)] == [0.0] * 4


def test_nothing_goes_on_into_the_ground():
    assert reach_of(Block(0, 0, 0.1, 0.3))[DOWN] == 0.0


def test_a_front_goes_on_backward_as_far_as_it_hides_what_is_behind():
    eye_level = Block(0, 0.55, 0.4, 0.1, d=0.01)
    assert reach_of(eye_level)[BACK] == MOST_M


def test_a_box_goes_on_to_the_next_and_no_further():
    front = Block(0, 0.55, 0.4, 0.1, d=0.01)
    wall = Block(0, 0, 2.0, 2.0, z=-0.155, d=0.1, fixed=True)  # its face lies 10 cm behind
    assert abs(reach_of(front, wall, hiding=(front,))[BACK] - MOST_M) < 1e-9  # background may be gone into
    assert (
        abs(reach_of(front, Block(0, 0, 2.0, 2.0, z=-0.155, d=0.1), hiding=(front,))[BACK] - 0.1)
        < STEP_M + 1e-9
    )


def test_what_stands_before_a_box_lets_it_go_on_down():
    upper = Block(0, 0.2, 0.1, 0.1, z=-0.3)
    before = Block(0, 0, 0.4, 0.3, z=-0.1)
    assert reach_of(upper)[DOWN] == 0.0
    assert abs(reach_of(upper, hiding=(upper, before))[DOWN] - 0.2) < 1e-9  # down to the ground


def test_grown_boxes_have_their_other_faces_where_they_were():
    boxes, _ = looked_at(Block(0, 0, 0.1, 0.3, tilt_deg=20.0), Block(1, 0, 0.2, 0.2))
    added = torch.zeros(2, 6, dtype=torch.float64)
    added[0, BACK], added[0, UP] = 0.07, 0.02
    moved = ((grown(boxes, added).face_centers() - boxes.face_centers()) * boxes.face_normals()).sum(dim=-1)
    assert torch.allclose(moved, added, atol=1e-12)
