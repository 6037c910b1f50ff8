"""Planes that many pixels agree on."""

from __future__ import annotations

from dataclasses import replace

import pytest
import torch
from torch import Tensor

from blockstab.segments.plane_votes import Pixels, Vote, fitted, moments
from tests.tolerance import EXACT

TILT, REACH, LEAST = 0.1, 0.01, 50
VOTE = Vote(tilt=TILT, bend=0.015, lean=0.003, fresh_share=0.5, budget=10**6)


def patch(
    normal: list[float], distance: float, count: int, generator: torch.Generator, noise: float = 0.0
) -> Pixels:
    """Pixels of a square of a plane, 30 cm wide, whose nearest point to the origin is its middle."""
    n = torch.nn.functional.normalize(torch.tensor(normal, dtype=torch.float64), dim=0)
    basis = torch.linalg.svd(n[None]).Vh[1:]
    place = 0.3 * torch.rand(count, 2, dtype=torch.float64, generator=generator) - 0.15
    off = noise * torch.randn(count, 1, dtype=torch.float64, generator=generator)
    points = place @ basis - (distance + off) * n
    turn = torch.rand(count, dtype=torch.float64, generator=generator)
    return Pixels(
        points,
        n.expand(count, 3),
        torch.full((count,), REACH, dtype=torch.float64),
        torch.ones_like(turn),
        turn,
    )


def together(*parts: Pixels) -> Pixels:
    return Pixels(*(torch.cat([getattr(part, name) for part in parts]) for name in vars(parts[0])))


def cap(generator: torch.Generator, count: int = 2000) -> Pixels:
    """Pixels of the half of a ball of 10 cm that faces the origin."""
    normals = torch.nn.functional.normalize(
        torch.randn(count, 3, dtype=torch.float64, generator=generator), dim=1
    )
    normals[:, 2] = -normals[:, 2].abs()
    points = 0.1 * normals + torch.tensor([0.0, 0.0, 1.0])
    turn = torch.rand(count, dtype=torch.float64, generator=generator)
    return Pixels(
        points, normals, torch.full((count,), REACH, dtype=torch.float64), torch.ones_like(turn), turn
    )


def plane(normal: list[float], offset: float) -> Tensor:
    n = torch.nn.functional.normalize(torch.tensor(normal, dtype=torch.float64), dim=0)
    return torch.cat([n, n.new_tensor([offset])])


def test_a_pixel_is_on_a_plane_that_it_is_near_and_faces_like() -> None:
    points = torch.tensor([[0.0, 0.0, 1.0], [0.0, 0.0, 1.009], [0.0, 0.0, 1.011], [0.0, 0.0, 1.0]]).double()
    normals = torch.tensor([[0.0, 0.0, -1.0]]).double().repeat(4, 1)
    normals[3] = torch.tensor([0.6, 0.0, -0.8])
    pixels = Pixels(
        points, normals, torch.full((4,), REACH).double(), torch.ones(4).double(), torch.zeros(4).double()
    )
    planes = plane([0, 0, -1], 1.0)[None]
    assert pixels.on(planes, TILT)[:, 0].tolist() == [True, True, False, False]
    assert pixels.on(planes, 0.3)[:, 0].tolist() == [True, True, False, True]
    assert pixels.on(planes, TILT, reaches=2.0)[:, 0].tolist() == [True, True, True, False]


def test_a_fit_is_that_of_the_singular_values(generator: torch.Generator) -> None:
    points = torch.rand(40, 3, dtype=torch.float64, generator=generator) * torch.tensor([1.0, 2.0, 0.1])
    points = points - torch.tensor([0.5, 1.0, 2.0])
    weight = torch.rand(40, dtype=torch.float64, generator=generator)
    found = fitted(moments(points, weight).sum(dim=0, keepdim=True))[0]
    center = (weight[:, None] * points).sum(dim=0) / weight.sum()
    normal = torch.linalg.svd(weight.sqrt()[:, None] * (points - center)).Vh[2]
    assert abs(float(normal @ found[:3])) == pytest.approx(1.0, abs=EXACT)
    assert float(center @ found[:3] + found[3]) == pytest.approx(0.0, abs=EXACT)
    assert float(found[3]) > 0


def test_a_fit_without_planes_has_none() -> None:
    assert fitted(torch.zeros(0, 10, dtype=torch.float64)).shape == (0, 4)


def test_votes_find_the_planes_and_the_largest_first(generator: torch.Generator) -> None:
    pixels = together(
        patch([0, 0, -1], 1.0, 300, generator, 0.002),
        patch([1, 0, -1], 1.2, 900, generator, 0.002),
        patch([0, 1, -1], 1.1, 600, generator, 0.002),
    )
    found = VOTE(pixels, LEAST)
    expected = torch.stack([plane([1, 0, -1], 1.2), plane([0, 1, -1], 1.1), plane([0, 0, -1], 1.0)])
    assert torch.allclose(found, expected, atol=3e-3)


def test_planes_with_too_few_pixels_are_none(generator: torch.Generator) -> None:
    pixels = together(patch([0, 0, -1], 1.0, 300, generator), patch([1, 0, -1], 1.2, LEAST - 1, generator))
    assert len(VOTE(pixels, LEAST)) == 1
    assert len(VOTE(pixels, LEAST - 1)) == 2
    assert len(VOTE(pixels, 301)) == 0


def test_something_round_is_no_plane_unless_bends_are_allowed(generator: torch.Generator) -> None:
    assert len(VOTE(cap(generator), LEAST)) == 0
    lax = Vote(tilt=TILT, bend=0.1, lean=0.1, fresh_share=0.5, budget=10**6)
    assert len(lax(cap(generator), LEAST)) > 0


def test_two_parallel_faces_are_two_planes_and_not_one_across_them(generator: torch.Generator) -> None:
    high, low = patch([0, 0, -1], 1.0, 500, generator), patch([0, 0, -1], 1.013, 500, generator)
    shift = torch.tensor([0.3, 0.0, 0.0], dtype=torch.float64)
    pixels = together(high, replace(low, points=low.points + shift))
    found = VOTE(pixels, LEAST)
    assert found[:, 3].sort().values.tolist() == pytest.approx([1.0, 1.013], abs=EXACT)


@pytest.mark.parametrize("count", [0, 1, 2])
def test_hardly_any_pixels_give_no_plane(count: int, generator: torch.Generator) -> None:
    assert VOTE(patch([0, 0, -1], 1.0, count, generator), LEAST).shape == (0, 4)


def test_the_work_is_bounded_and_large_planes_are_still_found(generator: torch.Generator) -> None:
    thrifty = Vote(tilt=TILT, bend=0.015, lean=0.003, fresh_share=0.5, budget=20_000)
    pixels = together(patch([0, 0, -1], 1.0, 2000, generator), patch([1, 0, -1], 1.2, 2000, generator))
    assert len(thrifty(pixels, LEAST)) == 2
