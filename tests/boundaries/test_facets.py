"""Planes through discs, against a least-squares fit pixel by pixel."""

from __future__ import annotations

import math

import pytest
import torch
from torch import Tensor

from blockstab.boundaries.facets import Facets, facets
from blockstab.rgbd.frame import Camera

HEIGHT, WIDTH, RADIUS = 40, 52, 4
CAMERA = Camera(60.0, 66.0, 24.0, 21.0)
SINGLE = 1e-4  # single precision: sums of a hundred products, then a quotient of differences


def rays() -> tuple[Tensor, Tensor]:
    x = (torch.arange(WIDTH, dtype=torch.float64) - CAMERA.cx) / CAMERA.fx
    y = (torch.arange(HEIGHT, dtype=torch.float64) - CAMERA.cy) / CAMERA.fy
    return x, y[:, None]


def fitted(inverse: Tensor) -> Facets:
    x, y = rays()
    return facets(inverse.float(), x.float(), y.float(), CAMERA, RADIUS)


def with_holes(inverse: Tensor, generator: torch.Generator) -> Tensor:
    """A fifth of the pixels lost."""
    return torch.where(torch.rand(inverse.shape, generator=generator) < 0.2, 0.0, inverse)


def test_planes_are_those_of_least_squares(generator: torch.Generator) -> None:
    x, y = rays()
    inverse = 1.2 + 0.5 * x - 0.3 * y
    inverse = inverse + 0.02 * torch.randn(HEIGHT, WIDTH, generator=generator, dtype=torch.float64)
    inverse = with_holes(inverse, generator)
    found = fitted(inverse)
    v, u = torch.meshgrid(torch.arange(HEIGHT), torch.arange(WIDTH), indexing="ij")
    for row, column in ((0, 0), (20, 30), (39, 26), (11, 51), (25, 3)):
        disc = ((v - row) ** 2 + (u - column) ** 2 <= RADIUS**2) & (inverse > 0)
        here = torch.stack(
            [x.expand_as(inverse)[disc], y.expand_as(inverse)[disc], torch.ones(int(disc.sum()))], 1
        )
        plane = torch.linalg.lstsq(here.double(), inverse[disc][:, None]).solution[:, 0]
        assert torch.allclose(found.normal[:, row, column].double(), plane / plane.norm(), atol=10 * SINGLE)
        assert float(found.distance[row, column]) == pytest.approx(1 / float(plane.norm()), rel=10 * SINGLE)
        variance = (inverse[disc] - here.double() @ plane).square().mean()
        assert float(found.variance[row, column]) == pytest.approx(float(variance), rel=0.01, abs=1e-6)


@pytest.mark.parametrize("tilt_deg", [0.0, 40.0, 75.0])
def test_a_plane_is_found_whatever_pixels_are_missing(tilt_deg: float, generator: torch.Generator) -> None:
    x, y = rays()
    normal = torch.tensor([0.0, math.sin(math.radians(tilt_deg)), math.cos(math.radians(tilt_deg))])
    inverse = (normal[0] * x + normal[1] * y + normal[2]) / 0.7
    found = fitted(with_holes(inverse.clamp(min=0.0), generator))
    known = found.distance < torch.inf
    assert float(known.double().mean()) > 0.7
    assert torch.allclose(found.normal[:, known], normal[:, None].expand(3, int(known.sum())), atol=SINGLE)
    assert torch.allclose(found.distance[known], torch.tensor(0.7), atol=SINGLE)
    assert float(found.variance[known].max()) < 1e-5  # a difference of squares of about 2


def test_too_few_pixels_or_a_line_of_them_make_no_plane() -> None:
    line, corner = torch.zeros(HEIGHT, WIDTH), torch.zeros(HEIGHT, WIDTH)
    line[:, 20:22], corner[:6, :6] = 1.0, 1.0
    assert bool(fitted(line).distance[:, :16].isinf().all())
    found = fitted(corner)
    assert float(found.distance[3, 3]) == pytest.approx(1.0, abs=SINGLE)
    assert bool(found.distance[9:, :].isinf().all())
    assert not found.normal[:, found.distance.isinf()].any()
