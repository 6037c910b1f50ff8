"""Where boxes touch, in worlds whose patches are plain to see."""

from __future__ import annotations

import math

import pytest
import torch

from blockstab.boxes.box import Boxes
from blockstab.stability.contacts import Contacts, contacts_of, islands_of, loosened
from blockstab.stability.support import GROUND
from blockstab.testing.worlds import Block, build
from tests.stability.touching import relations, touching


def between(contacts: Contacts, below: int, above: int) -> set[tuple[float, ...]]:
    mine = (contacts.supporter == below) & (contacts.supported == above)
    return {tuple(round(v, 6) for v in point) for point in contacts.point[mine].tolist()}


def test_a_box_on_the_ground_touches_it_with_the_corners_of_its_lower_face():
    found = touching(*build(Block(0, 0, 0.2, 0.1, d=0.4)))
    assert between(found, GROUND, 0) == {(x, 0.0, z) for x in (-0.1, 0.1) for z in (-0.2, 0.2)}
    assert found.normal.tolist() == [[0.0, 1.0, 0.0]] * 4


def test_a_box_on_another_touches_it_where_their_faces_overlap():
    found = touching(*build(Block(0, 0, 0.2, 0.1), Block(0.15, 0.1, 0.2, 0.1, z=0.02)))
    assert between(found, 0, 1) == {(x, 0.1, z) for x in (0.05, 0.1) for z in (-0.03, 0.05)}


def test_two_boxes_side_by_side_touch_in_the_lower_of_their_heights():
    found = touching(*build(Block(0, 0, 0.1, 0.1), Block(0.1, 0, 0.1, 0.3)))
    assert between(found, 0, 1) == {(0.05, y, z) for y in (0.0, 0.1) for z in (-0.05, 0.05)}
    sideways = found.normal[(found.supporter == 0) & (found.supported == 1)]
    assert sideways.tolist() == [[1.0, 0.0, 0.0]] * 4


@pytest.mark.parametrize("swapped", [False, True])
def test_an_edge_on_a_face_touches_along_what_they_share(swapped):
    # A cube on its edge, on a narrower plate.
    blocks = [Block(0, 0, 0.3, 0.1, d=0.06), Block(0.05, 0.1, 0.1, 0.1, tilt_deg=45.0)]
    boxes, movable = build(*(blocks[::-1] if swapped else blocks))
    found = touching(boxes, movable)
    below, above = (1, 0) if swapped else (0, 1)
    first, second = min(below, above), max(below, above)
    assert between(found, first, second) == {(0.0, 0.1, -0.03), (0.0, 0.1, 0.03)}


def test_a_corner_touches_in_a_point():
    boxes, movable = build(Block(0, 0, 0.4, 0.1), Block(0, 0.1, 0.1, 0.1))
    axis = torch.tensor([1.0, 1.0, 1.0], dtype=torch.float64) / math.sqrt(3)
    # The diagonal of the cube is turned upright.
    up = torch.tensor([0.0, 1.0, 0.0], dtype=torch.float64)
    turn = torch.linalg.cross(axis, up)
    sine, cosine = float(turn.norm()), float(axis @ up)
    x, y, z = (turn / sine).tolist()
    skew = torch.tensor([[0, -z, y], [z, 0, -x], [-y, x, 0]], dtype=torch.float64)
    rotation = torch.eye(3, dtype=torch.float64) + sine * skew + (1 - cosine) * skew @ skew
    center = torch.stack([boxes.center[0], torch.tensor([0.0, 0.1 + 0.05 * math.sqrt(3), 0.0]).double()])
    turned = Boxes(center, torch.stack([boxes.rotation[0], rotation]), boxes.half_extent)
    found = touching(turned, movable)
    assert between(found, 0, 1) == {(0.0, 0.1, 0.0)}


def test_a_face_that_leans_less_than_asked_lies_flat():
    boxes, movable = build(Block(0, 0, 0.2, 0.1, tilt_deg=3.0))
    candidates = relations(boxes, movable)
    count = [len(contacts_of(boxes, candidates, angle_deg=angle).point) for angle in (1.0, 5.0)]
    assert count == [2, 4]


def test_loose_contacts_reach_further_along_their_patches_alone():
    found = touching(*build(Block(0, 0, 0.2, 0.1)))
    loose = loosened(found, torch.tensor([0.01], dtype=torch.float64))
    assert len(loose.point) == 4 * len(found.point)
    shift = (loose.point.view(-1, 4, 3) - found.point[:, None]).norm(dim=2)
    torch.testing.assert_close(shift, torch.full_like(shift, 0.01))
    assert loose.point[:, 1].abs().max() < 1e-12


def test_what_touches_only_by_background_are_two_islands():
    blocks = (Block(0, 0, 0.6, 0.1, fixed=True), Block(-0.2, 0.1, 0.1, 0.1), Block(0.2, 0.1, 0.1, 0.1))
    boxes, movable = build(*blocks, Block(0.2, 0.2, 0.1, 0.1))
    islands = [(own.tolist(), part) for own, part in islands_of(touching(boxes, movable), movable)]
    assert [own for own, _ in islands] == [[0, 1], [0, 2, 3]]
    assert set(zip(islands[1][1].supporter.tolist(), islands[1][1].supported.tolist(), strict=True)) == {
        (0, 1), (1, 2)
    }  # fmt: skip
