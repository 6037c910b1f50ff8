"""Rays against boxes whose answer is known."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import torch

from blockstab.boxes.box import Boxes
from blockstab.datasets.raycasting import NOTHING, RayCaster
from tests.tolerance import EXACT

Upright = Callable[[Sequence[tuple[float, ...]]], Boxes]


def vectors(*rows: tuple[float, float, float]) -> torch.Tensor:
    return torch.tensor([rows], dtype=torch.float64)


def test_a_ray_at_each_face_meets_that_face_at_its_distance(upright: Upright) -> None:
    boxes = upright([(0.0, 0.0, 0.0, 0.1, 0.2, 0.3), (5.0, 0.0, 0.0, 0.1, 0.1, 0.1)])
    caster = RayCaster(boxes)
    for face, normal in enumerate(boxes.face_normals()[0]):
        seen = caster.first_hit(normal, -normal[None, None])
        assert seen.box.item() == 0
        assert seen.face.item() == face
        assert abs(seen.depth.item() - (1.0 - float(boxes.half_extent[0, face // 2]))) < EXACT
        assert torch.allclose(seen.normals[0, 0], normal, atol=EXACT)
        assert torch.allclose(seen.points[0, 0], boxes.face_centers()[0, face], atol=EXACT)


def test_a_ray_meets_the_nearest_box_or_nothing(upright: Upright) -> None:
    caster = RayCaster(upright([(0.0, 0.0, 3.0, 1.0, 1.0, 0.5), (0.0, 0.0, 2.0, 0.1, 0.1, 0.1)]))
    seen = caster.first_hit(
        torch.zeros(3, dtype=torch.float64), vectors((0, 0, 1), (0.2, 0, 1), (2, 0, 1), (0, 0, -1))
    )
    assert seen.box.tolist() == [[1, 0, NOTHING, NOTHING]]
    assert torch.allclose(seen.depth[0, :2], torch.tensor([1.9, 2.5], dtype=torch.float64), atol=EXACT)
    assert (seen.depth[0, 2:] == 0).all()
    assert (seen.normals[0, 2:] == 0).all()


def test_a_point_behind_a_box_is_hidden_and_one_on_it_is_not(upright: Upright) -> None:
    caster = RayCaster(upright([(0.0, 0.0, 2.0, 0.1, 0.1, 0.1)]))
    source = torch.zeros(3, dtype=torch.float64)
    points = vectors((0, 0, 3), (0.05, 0.05, 1.9), (0.5, 0, 3), (0.05, 0, 2.1))
    assert caster.hidden_from(source, points).tolist() == [[True, False, False, True]]


def test_a_box_shades_what_lies_behind_it_but_not_the_side_to_the_lamp(upright: Upright) -> None:
    caster = RayCaster(upright([(0.0, 1.0, 0.0, 0.1, 0.1, 0.1)]))
    lamp = torch.tensor([0.0, 1.0, 0.0], dtype=torch.float64)
    points = vectors((0, 0, 0), (0.05, 1.1, 0.05), (0.5, 0, 0))
    assert caster.shaded_from(lamp, points).tolist() == [[True, False, False]]
