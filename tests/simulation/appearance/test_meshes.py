"""Triangle meshes against the solids they stand for."""

from __future__ import annotations

import itertools
import math

import pytest
import torch

from blockstab.boxes.box import Boxes
from blockstab.simulation.appearance.meshes import Mesh, mesh_of
from blockstab.simulation.physics.solids import Part, Solid
from tests.simulation.scenery import of_one_part
from tests.tolerance import EXACT

BOX = of_one_part("box", (0.1, 0.2, 0.3), "carton")
TIN = of_one_part("cylinder", (0.05, 0.1, 0.05), "tin")
BALL = of_one_part("sphere", (0.05, 0.05, 0.05), "ball")


def hull_of(points: torch.Tensor) -> Solid:
    half = (points.amax(dim=0) - points.amin(dim=0)) / 2
    zero = torch.zeros(3, dtype=torch.float64)
    return Solid("bowl", "bowl", half, (Part("hull", zero, torch.eye(3, dtype=torch.float64), half, points),))


def ring(segments: int, radius: float, height: float) -> torch.Tensor:
    angle = 2 * math.pi * torch.arange(segments, dtype=torch.float64) / segments
    level = torch.full_like(angle, height)
    return torch.stack([radius * angle.sin(), level, radius * angle.cos()], dim=-1)


CUBE = hull_of(0.1 * torch.tensor(list(itertools.product((-1.0, 1.0), repeat=3)), dtype=torch.float64))
DRUM = hull_of(torch.cat([ring(32, 0.08, -0.05), ring(32, 0.08, 0.05)]))


def volume(mesh: Mesh) -> float:
    """By the divergence theorem, from triangles turned so that they look the way of their normals."""
    a, b, c = mesh.corners.unbind(dim=1)
    plane = torch.linalg.cross(b - a, c - a)
    outward = (plane * mesh.normals.mean(dim=1)).sum(dim=-1).sign()
    return float(((a * plane).sum(dim=-1) * outward).sum() / 6)


@pytest.mark.parametrize(
    ("solid", "expected", "tolerance"),
    [
        (BOX, 8 * 0.1 * 0.2 * 0.3, EXACT),
        (TIN, math.pi * 0.05**2 * 0.2, 2e-3),
        (BALL, 4 / 3 * math.pi * 0.05**3, 5e-3),
        (CUBE, 0.2**3, EXACT),
    ],
)
def test_a_mesh_holds_the_volume_of_its_solid(solid: Solid, expected: float, tolerance: float) -> None:
    assert volume(mesh_of(solid)) == pytest.approx(expected, rel=tolerance)


def test_facets_of_a_tin_and_a_ball_of_5_cm_lie_within_a_tenth_of_a_millimetre() -> None:
    tin, ball = mesh_of(TIN), mesh_of(BALL)
    side = tin.corners[tin.patch == 0]
    middles = (side[:, [0, 1, 2]] + side[:, [1, 2, 0]]) / 2
    assert float((0.05 - middles[..., [0, 2]].norm(dim=-1)).max()) < 1e-4
    assert float((0.05 - ball.corners.mean(dim=1).norm(dim=-1)).max()) < 1e-4


def test_patches_of_a_box_are_the_faces_of_boxes() -> None:
    boxes = Boxes(torch.zeros(1, 3), torch.eye(3)[None], BOX.half_extent[None])
    mesh = mesh_of(BOX)
    assert [patch.face for patch in mesh.patches] == list(range(6))
    for face, normal in enumerate(boxes.face_normals()[0].double()):
        own = mesh.patch == face
        assert int(own.sum()) == 2
        assert torch.equal(mesh.normals[own], normal.expand(2, 3, 3))


@pytest.mark.parametrize("solid", [BOX, TIN, BALL, DRUM])
def test_print_is_to_scale_and_never_mirrored(solid: Solid) -> None:
    mesh = mesh_of(solid)
    sides, flat = (values[:, 1:] - values[:, :1] for values in (mesh.corners, mesh.uv))
    plane = torch.linalg.cross(sides[:, 0], sides[:, 1])
    on_paper = flat[:, 0, 0] * flat[:, 1, 1] - flat[:, 0, 1] * flat[:, 1, 0]
    outward = (plane * mesh.normals.mean(dim=1)).sum(dim=-1)
    level = plane[:, 1].abs() < 0.99 * plane.norm(dim=-1)
    if solid is not DRUM:  # a hull is wrapped round its axis, so its ends have no print to speak of
        level = torch.ones_like(level)
    assert (on_paper[level] * outward[level] > 0).all()
    if solid is not BALL:  # whose paper is as wide at the poles as it is at the equator
        ratio = on_paper[level].abs() / plane[level].norm(dim=-1)
        assert torch.allclose(ratio, torch.ones_like(ratio), atol=0.01)


def test_the_label_of_a_tin_runs_once_round_it() -> None:
    mesh = mesh_of(TIN)
    side = mesh.uv[mesh.patch == 0].flatten(0, 1)
    assert side.amin(dim=0).tolist() == pytest.approx([0.0, 0.0])
    assert side.amax(dim=0).tolist() == pytest.approx([2 * math.pi * 0.05, 0.2])
    assert mesh.patches[0][2:4] == pytest.approx((2 * math.pi * 0.05, 0.2))
    assert mesh.patches[0].echo == TIN.parts[0].echo == 1.0


def test_blunt_edges_of_hulls_are_smooth_and_sharp_ones_are_not() -> None:
    drum, cube = mesh_of(DRUM), mesh_of(CUBE)
    outward = drum.corners * torch.tensor([1.0, 0.0, 1.0], dtype=torch.float64)
    outward = outward / outward.norm(dim=-1, keepdim=True)
    side = drum.normals[..., 1].abs() < 0.5
    assert float((drum.normals * outward).sum(dim=-1)[side].min()) > math.cos(math.radians(3))
    assert torch.allclose(cube.normals.abs().amax(dim=-1), torch.ones(12, 3, dtype=torch.float64))


def test_parts_keep_their_place_and_turn() -> None:
    turn = torch.tensor([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]], dtype=torch.float64)
    shift, half = (torch.tensor(v, dtype=torch.float64) for v in ([0.3, 0.0, 0.0], [0.02, 0.1, 0.02]))
    mesh = mesh_of(Solid("bottle", "bottle", half, (*TIN.parts, Part("cylinder", shift, turn, half))))
    second = mesh.corners[mesh.patch >= 3].flatten(0, 1)
    assert second.amax(dim=0).tolist() == pytest.approx([0.4, 0.02, 0.02])
    assert second.amin(dim=0).tolist() == pytest.approx([0.2, -0.02, -0.02])
    assert len(mesh.patches) == 6
