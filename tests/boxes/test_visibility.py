"""Which faces the camera sees, and which points lie on them."""

from __future__ import annotations

import pytest
import torch

from blockstab.boxes.box import Boxes
from blockstab.boxes.visibility import nearest_face, visible_faces, visible_share
from tests.seen_boxes import boxes_showing, on_faces, random_turns, seen_points
from tests.tolerance import EXACT


def box(center: list[float], half: float = 0.1) -> Boxes:
    return Boxes(
        torch.tensor([center], dtype=torch.float64),
        torch.eye(3, dtype=torch.float64)[None],
        torch.full((1, 3), half, dtype=torch.float64),
    )


@pytest.mark.parametrize(
    ("center", "seen"),
    [
        ([0.0, 0.0, -1.0], [4]),  # straight ahead, along -z: its +z face
        ([0.05, -0.5, -1.0], [2, 4]),  # below: its top too
        ([-0.5, 0.5, 1.0], [0, 3, 5]),  # a corner
        ([0.02, 0.03, -0.04], []),  # the camera is inside
    ],
)
def test_the_faces_seen_are_those_that_look_at_the_camera(center: list[float], seen: list[int]) -> None:
    assert visible_faces(box(center))[0].nonzero()[:, 0].tolist() == seen


def test_a_face_seen_from_its_own_plane_is_not_seen() -> None:
    assert visible_faces(box([0.1, 0.0, -1.0]))[0].nonzero()[:, 0].tolist() == [4]


def test_no_more_than_three_faces_are_seen_and_none_with_its_opposite(generator: torch.Generator) -> None:
    boxes = Boxes(
        2 * torch.randn(5000, 3, generator=generator, dtype=torch.float64),
        random_turns(5000, generator),
        0.005 + torch.rand(5000, 3, generator=generator, dtype=torch.float64),
    )
    seen = visible_faces(boxes)
    inside = (boxes.local(torch.zeros(5000, 1, 3).double())[:, 0].abs() < boxes.half_extent).all(dim=1)
    assert int(seen.sum(dim=1).max()) == 3
    assert torch.equal(seen.any(dim=1), ~inside)
    assert not bool((seen[:, ::2] & seen[:, 1::2]).any())


@pytest.mark.parametrize("faces", [1, 2, 3])
def test_points_on_seen_faces_have_a_share_of_one(faces: int, generator: torch.Generator) -> None:
    boxes = boxes_showing(faces, 30, generator)
    assert visible_faces(boxes).sum(dim=1).tolist() == [faces] * 30
    points = seen_points(boxes, 500, generator)
    share = visible_share(boxes, points, torch.ones(30, 500, dtype=torch.bool))
    assert share.dtype == torch.float64
    # A point within 1e-3 of an edge may be as near to the hidden face beyond it.
    assert float(share.min()) > 0.98
    middle = boxes.center[:, None] + 0.98 * (points - boxes.center[:, None])
    assert float(visible_share(boxes, middle, torch.ones(30, 500, dtype=torch.bool)).min()) > 0.9


def test_points_on_hidden_faces_have_a_share_of_zero(generator: torch.Generator) -> None:
    boxes = boxes_showing(3, 30, generator)
    hidden = torch.multinomial((~visible_faces(boxes)).double(), 500, True, generator=generator)
    place = 1.8 * torch.rand(30, 500, 3, generator=generator, dtype=torch.float64) - 0.9
    share = visible_share(boxes, on_faces(boxes, hidden, place), torch.ones(30, 500, dtype=torch.bool))
    assert share.tolist() == [0.0] * 30


def test_a_box_in_front_of_its_points_has_a_low_share(generator: torch.Generator) -> None:
    # Two faces of a box fit the far side of a box before them as well: only the share tells them apart.
    boxes = boxes_showing(3, 30, generator)
    points = seen_points(boxes, 500, generator)
    camera = -boxes.local(torch.zeros(30, 1, 3, dtype=torch.float64))[:, 0]
    step = boxes.rotation @ (2 * boxes.half_extent * -camera.sign())[..., None]
    nearer = Boxes(boxes.center + step[..., 0], boxes.rotation, boxes.half_extent)
    present = torch.ones(30, 500, dtype=torch.bool)
    assert float(visible_share(nearer, points, present).max()) < 0.02
    assert float(visible_share(boxes, points, present).min()) > 0.98


def test_points_that_are_absent_do_not_count() -> None:
    one = box([0.0, 0.0, -1.0])
    points = torch.tensor([[[0.0, 0.0, -0.9], [0.0, 0.0, -1.1], [0.0, 0.0, -1.1]]], dtype=torch.float64)
    for present, share in (([True, False, False], 1.0), ([True, True, False], 0.5), ([False] * 3, 0.0)):
        assert visible_share(one, points, torch.tensor([present])).tolist() == [share]


def test_the_nearest_face_is_numbered_as_the_normals_are(generator: torch.Generator) -> None:
    boxes = boxes_showing(3, 5, generator)
    face = torch.arange(6).expand(5, -1)
    points = on_faces(boxes, face, torch.zeros(5, 6, 3, dtype=torch.float64))
    assert torch.equal(nearest_face(boxes, points), face)
    assert float((points - boxes.face_centers()).abs().max()) < EXACT
