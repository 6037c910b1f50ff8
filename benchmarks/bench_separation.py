"""Gaps of 10,000 pairs of boxes, beside coal and fcl; the brackets in the table are ratios to the fastest."""

from __future__ import annotations

import math

import coal
import fcl
import pytest
import torch
from pytest_benchmark.fixture import BenchmarkFixture
from scipy.spatial.transform import Rotation
from torch import Tensor

from blockstab.boxes.box import Boxes
from blockstab.boxes.separation import separation

BOXES, PAIRS = 200, 10_000

pytestmark = pytest.mark.benchmark(group=f"gap of {PAIRS} pairs of boxes")


@pytest.fixture(scope="module")
def boxes() -> Boxes:
    generator = torch.Generator().manual_seed(0)
    turns = math.pi * torch.randn(BOXES, 3, dtype=torch.float64, generator=generator)
    return Boxes(
        center=torch.rand(BOXES, 3, dtype=torch.float64, generator=generator),
        rotation=torch.from_numpy(Rotation.from_rotvec(turns.numpy()).as_matrix()),
        half_extent=0.05 + 0.3 * torch.rand(BOXES, 3, dtype=torch.float64, generator=generator),
    )


@pytest.fixture(scope="module")
def pairs() -> tuple[Tensor, Tensor]:
    first, step = torch.randint(1, BOXES, (2, PAIRS), generator=torch.Generator().manual_seed(1))
    return first, (first + step) % BOXES


def test_blockstab(benchmark: BenchmarkFixture, boxes: Boxes, pairs: tuple[Tensor, Tensor]) -> None:
    benchmark(separation, boxes, *pairs)


def test_blockstab_with_gradient(
    benchmark: BenchmarkFixture, boxes: Boxes, pairs: tuple[Tensor, Tensor]
) -> None:
    fields = [field.clone().requires_grad_() for field in (boxes.center, boxes.rotation, boxes.half_extent)]

    def gradient() -> tuple[Tensor, ...]:
        return torch.autograd.grad(separation(Boxes(*fields), *pairs).gap.sum(), fields)

    benchmark(gradient)


def test_coal(benchmark: BenchmarkFixture, boxes: Boxes, pairs: tuple[Tensor, Tensor]) -> None:
    shapes = [coal.Box(*sides) for sides in (2 * boxes.half_extent).tolist()]
    poses = [
        coal.Transform3s(r, c) for r, c in zip(boxes.rotation.numpy(), boxes.center.numpy(), strict=True)
    ]
    request, found = coal.DistanceRequest(), coal.DistanceResult()
    numbers = list(zip(*(index.tolist() for index in pairs), strict=True))

    def distances() -> list[float]:
        out = []
        for i, j in numbers:
            found.clear()
            out.append(coal.distance(shapes[i], poses[i], shapes[j], poses[j], request, found))
        return out

    benchmark(distances)


def test_fcl(benchmark: BenchmarkFixture, boxes: Boxes, pairs: tuple[Tensor, Tensor]) -> None:
    objects = [
        fcl.CollisionObject(fcl.Box(*sides), fcl.Transform(r, c))
        for sides, r, c in zip(
            (2 * boxes.half_extent).tolist(), boxes.rotation.numpy(), boxes.center.numpy(), strict=True
        )
    ]
    request = fcl.CollisionRequest(enable_contact=True)
    numbers = list(zip(*(index.tolist() for index in pairs), strict=True))

    def depths() -> list[float]:
        out = []
        for i, j in numbers:
            found = fcl.CollisionResult()
            fcl.collide(objects[i], objects[j], request, found)
            out.append(max((contact.penetration_depth for contact in found.contacts), default=0.0))
        return out

    benchmark(depths)
