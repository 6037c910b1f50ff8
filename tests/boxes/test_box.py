"""Boxes: their corners, edges and faces, and what is refused."""

from __future__ import annotations

import math

import pytest
import torch
from scipy.spatial.transform import Rotation
from torch import Tensor

from blockstab.boxes.box import MIN_HALF_EXTENT, Boxes, checked, concatenate
from tests.tolerance import EXACT


@pytest.fixture
def boxes(generator: torch.Generator) -> Boxes:
    spread = torch.randn(7, 4, dtype=torch.float64, generator=generator)
    return Boxes(
        center=torch.randn(7, 3, dtype=torch.float64, generator=generator),
        rotation=torch.from_numpy(Rotation.from_quat(spread.numpy()).as_matrix()),
        half_extent=0.05 + torch.rand(7, 3, dtype=torch.float64, generator=generator),
    )


def close(found: Tensor, expected: Tensor) -> None:
    torch.testing.assert_close(found, expected, rtol=0.0, atol=EXACT)


def test_convention_box_axes_are_columns() -> None:
    quarter_turn = torch.tensor([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]], dtype=torch.float64)
    long_in_x = torch.tensor([[0.5, 0.1, 0.2]], dtype=torch.float64)
    turned = Boxes(torch.zeros(1, 3, dtype=torch.float64), quarter_turn[None], long_in_x)
    assert turned.face_normals()[0, 0].tolist() == [0.0, 1.0, 0.0]
    assert turned.face_normals()[0, 2].tolist() == [-1.0, 0.0, 0.0]
    assert turned.corners()[0].amax(dim=0).tolist() == [0.1, 0.5, 0.2]


def test_corners_follow_the_bits_of_their_number() -> None:
    upright = Boxes(
        torch.tensor([[1.0, 2.0, 3.0]], dtype=torch.float64),
        torch.eye(3, dtype=torch.float64)[None],
        torch.tensor([[0.1, 0.2, 0.3]], dtype=torch.float64),
    )
    assert upright.corners()[0, 0].tolist() == pytest.approx([0.9, 1.8, 2.7])
    assert upright.corners()[0, 1].tolist() == pytest.approx([0.9, 1.8, 3.3])
    assert upright.corners()[0, 4].tolist() == pytest.approx([1.1, 1.8, 2.7])


def test_every_edge_is_as_long_as_a_side(boxes: Boxes) -> None:
    start, end = boxes.edges().unbind(dim=2)
    length = torch.linalg.vector_norm(end - start, dim=2).sort(dim=1).values
    close(length, (2 * boxes.half_extent).repeat_interleave(4, dim=1).sort(dim=1).values)
    ends = boxes.edges().flatten(1, 2)
    assert all(len(set(map(tuple, box.tolist()))) == 8 for box in ends)


def test_face_centers_are_the_mean_of_four_corners_and_lie_where_the_normals_point(boxes: Boxes) -> None:
    height = (
        (boxes.corners()[:, None] - boxes.center[:, None, None]) * boxes.face_normals()[:, :, None]
    ).sum(-1)
    on_face = height > height.amax(dim=2, keepdim=True) - EXACT
    assert (on_face.sum(dim=2) == 4).all()
    mean = (boxes.corners()[:, None] * on_face[..., None]).sum(dim=2) / 4
    close(boxes.face_centers(), mean)
    assert (((boxes.face_centers() - boxes.center[:, None]) * boxes.face_normals()).sum(-1) > 0).all()


def test_volume_is_that_of_the_edges_at_a_corner(boxes: Boxes) -> None:
    corners = boxes.corners()
    close(boxes.volume(), torch.linalg.det(corners[:, [1, 2, 4]] - corners[:, :1]).abs())


def test_local_coordinates_of_the_corners_are_the_half_extents(boxes: Boxes) -> None:
    close(boxes.local(boxes.corners()).abs(), boxes.half_extent[:, None].expand(-1, 8, -1))


def test_turning_the_frame_turns_every_corner(boxes: Boxes) -> None:
    turn = torch.from_numpy(Rotation.from_rotvec([0.3, -1.0, 0.5]).as_matrix())
    close(boxes.rotated(turn).corners(), boxes.corners() @ turn.T)
    close(boxes.rotated(turn).volume(), boxes.volume())
    checked(boxes.rotated(turn))


def test_a_selection_joined_again_is_the_same(boxes: Boxes) -> None:
    joined = concatenate([boxes[:2], boxes[torch.tensor([2, 3])], boxes[[4, 5, 6]]])
    assert len(joined) == 7
    assert torch.equal(joined.corners(), boxes.corners())


def test_boxes_are_differentiable(boxes: Boxes) -> None:
    fields = [f.clone().requires_grad_() for f in (boxes.center, boxes.rotation, boxes.half_extent)]
    assert torch.autograd.gradcheck(lambda *f: Boxes(*f).corners(), fields)
    assert torch.autograd.gradcheck(lambda *f: Boxes(*f).volume(), fields)


def test_good_boxes_pass_the_check_unchanged(boxes: Boxes) -> None:
    assert checked(boxes) is boxes
    assert len(checked(boxes[:0])) == 0


@pytest.mark.parametrize(
    ("field", "value", "message"),
    [
        ("center", math.nan, "Box 3 holds a value that is not finite"),
        ("half_extent", math.inf, "Box 3 holds a value that is not finite"),
        ("half_extent", 0.5 * MIN_HALF_EXTENT, "at least 0.005 m, but those of box 3 are"),
        ("rotation", 0.5, "orthonormal columns, but those of box 3 miss it by 7.5e-01"),
        ("rotation", -1.0, "the determinant of box 3 is -1.000; negate one column"),
    ],
)
def test_the_check_names_the_box_at_fault(boxes: Boxes, field: str, value: float, message: str) -> None:
    fields = {name: getattr(boxes, name).clone() for name in ("center", "rotation", "half_extent")}
    fields[field][3] = fields[field][3] * value if field == "rotation" else value
    with pytest.raises(ValueError, match=message):
        checked(Boxes(**fields))


def test_the_check_names_the_shape_at_fault(boxes: Boxes) -> None:
    with pytest.raises(
        ValueError, match=r"7 centres need rotation of shape \(7, 3, 3\), but got \(6, 3, 3\)"
    ):
        checked(Boxes(boxes.center, boxes.rotation[:6], boxes.half_extent))
    with pytest.raises(ValueError, match=r"half_extent of shape \(7, 3\), but got \(7, 2\)"):
        checked(Boxes(boxes.center, boxes.rotation, boxes.half_extent[:, :2]))
