"""Rays against solids whose answer is known."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import torch

from blockstab.boxes.box import Boxes
from blockstab.simulation.appearance.raycasting import NOTHING, RayCaster
from tests.simulation.scenery import of_one_part, pile_of_boxes, standing
from tests.tolerance import EXACT

Upright = Callable[[Sequence[tuple[float, ...]]], Boxes]
FACET = 1e-4  # metres that a mesh lies inside what is round


def vectors(*rows: tuple[float, float, float]) -> torch.Tensor:
    return torch.tensor([rows], dtype=torch.float64)


def test_a_ray_at_each_face_meets_that_face_at_its_distance(upright: Upright) -> None:
    boxes = upright([(0.0, 0.0, 0.0, 0.1, 0.2, 0.3), (5.0, 0.0, 0.0, 0.1, 0.1, 0.1)])
    caster = RayCaster(pile_of_boxes(boxes))
    for face, normal in enumerate(boxes.face_normals()[0]):
        seen = caster.first_hit(normal, -normal[None, None])
        assert seen.solid.item() == 0
        assert seen.patch.item() == face
        assert abs(seen.depth.item() - (1.0 - float(boxes.half_extent[0, face // 2]))) < EXACT
        assert torch.allclose(seen.normals[0, 0], normal, atol=1e-6)
        assert torch.allclose(seen.points[0, 0], boxes.face_centers()[0, face], atol=EXACT)


def test_slanted_rays_meet_a_turned_face_exactly(upright: Upright, generator: torch.Generator) -> None:
    turn = torch.linalg.qr(torch.randn(3, 3, generator=generator, dtype=torch.float64)).Q
    boxes = upright([(0.0, 0.0, 0.0, 0.1, 0.2, 0.3)]).rotated(turn * torch.linalg.det(turn))
    eye = torch.tensor([0.4, 0.9, 1.1], dtype=torch.float64)
    rays = 0.05 * torch.randn(40, 25, 3, generator=generator, dtype=torch.float64) - eye
    seen = RayCaster(pile_of_boxes(boxes)).first_hit(eye, rays)
    assert (seen.solid == 0).all()
    faces = boxes.face_normals()[0][seen.patch], boxes.face_centers()[0][seen.patch]
    assert float(((seen.points - faces[1]) * faces[0]).sum(dim=-1).abs().max()) < EXACT


def test_a_ray_meets_the_nearest_box_or_nothing(upright: Upright) -> None:
    boxes = upright([(0.0, 0.0, 3.0, 1.0, 1.0, 0.5), (0.0, 0.0, 2.0, 0.1, 0.1, 0.1)])
    seen = RayCaster(pile_of_boxes(boxes)).first_hit(
        torch.zeros(3, dtype=torch.float64), vectors((0, 0, 1), (0.2, 0, 1), (2, 0, 1), (0, 0, -1))
    )
    assert seen.solid.tolist() == [[1, 0, NOTHING, NOTHING]]
    assert torch.allclose(seen.depth[0, :2], torch.tensor([1.9, 2.5], dtype=torch.float64), atol=EXACT)
    assert (seen.depth[0, 2:] == 0).all()
    assert (seen.normals[0, 2:] == 0).all()


def test_round_things_are_met_within_a_facet_and_have_smooth_normals(generator: torch.Generator) -> None:
    tin = of_one_part("cylinder", (0.05, 0.1, 0.05), "tin")
    ball = of_one_part("sphere", (0.05, 0.05, 0.05), "ball")
    eye = torch.tensor([0.1, 0.1, 1.0], dtype=torch.float64)
    spread = torch.rand(2000, 3, generator=generator, dtype=torch.float64) - 0.5
    for solid, flat in ((tin, torch.tensor([1.0, 0.0, 1.0])), (ball, torch.ones(3))):
        middle = torch.tensor([0.0, float(solid.half_extent[1]), 0.0], dtype=torch.float64)
        caster = RayCaster(standing((solid, 0.0, 0.0)))
        seen = caster.first_hit(eye, middle + 0.06 * spread - eye)
        side = (seen.solid == 0) & (seen.patch == 0)
        assert int(side.sum()) > 1000
        outward = ((seen.points - middle) * flat)[side]
        inside = 0.05 - outward.norm(dim=-1)
        assert float(inside.min()) > -EXACT
        assert float(inside.max()) < FACET
        smooth = (outward / outward.norm(dim=-1, keepdim=True) * seen.normals[side]).sum(dim=-1)
        assert float(smooth.min()) > 1 - 1e-4


def test_a_point_behind_a_box_is_hidden_and_one_on_it_is_not(upright: Upright) -> None:
    caster = RayCaster(pile_of_boxes(upright([(0.0, 0.0, 2.0, 0.1, 0.1, 0.1)])))
    points = vectors((0, 0, 3), (0.05, 0.05, 1.9), (0.5, 0, 3), (0.05, 0, 2.1))
    source = torch.zeros_like(points)
    assert caster.hidden_from(source, points).tolist() == [[True, False, False, True]]


def test_a_box_shades_what_lies_behind_it_within_reach(upright: Upright) -> None:
    caster = RayCaster(pile_of_boxes(upright([(0.0, 1.0, 0.0, 0.1, 0.1, 0.1)])))
    points = vectors((0, 0, 0), (0.05, 1.1, 0.05), (0.5, 0, 0))
    up = vectors((0, 1, 0)).expand_as(points)
    assert caster.shaded(points, up, 2.0).tolist() == [[True, False, False]]
    assert not caster.shaded(points, up, 0.5).any()
