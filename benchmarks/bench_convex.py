"""Hulls and intersections of convex polygons, beside shapely's vectorised calls on geometries already built.

The brackets in the tables are ratios to the fastest. `from_points` also builds the geometries and reads the
answer back, as a caller with tensors must.
"""

from __future__ import annotations

import pytest
import shapely
import torch
from pytest_benchmark.fixture import BenchmarkFixture
from torch import Tensor

from blockstab.geometry.convex_hulls import Polygons, area, clip, hull

PAIRS = 1000
SETS = 5000


def point_sets(size: int) -> Tensor:
    generator = torch.Generator().manual_seed(size)
    return torch.rand(SETS, size, 2, dtype=torch.float64, generator=generator)


def hexagons(seed: int) -> Polygons:
    generator = torch.Generator().manual_seed(seed)
    angle = torch.rand(PAIRS, 6, dtype=torch.float64, generator=generator) + torch.arange(6)
    corners = 0.5 * torch.polar(torch.ones_like(angle), angle * (torch.pi / 3))
    center = 0.6 * torch.rand(PAIRS, 1, 2, dtype=torch.float64, generator=generator)
    return hull(torch.view_as_real(corners) + center)


@pytest.mark.benchmark(group=f"area shared by {PAIRS} pairs of hexagons")
class TestClip:
    def test_blockstab(self, benchmark: BenchmarkFixture) -> None:
        first, second = hexagons(1), hexagons(2)
        benchmark(lambda: area(clip(first, second)))

    def test_shapely(self, benchmark: BenchmarkFixture) -> None:
        first, second = (shapely.polygons(hexagons(seed).vertices.numpy()) for seed in (1, 2))
        benchmark(lambda: shapely.area(shapely.intersection(first, second)))


@pytest.mark.parametrize("size", [8, 16, 32, 64])
class TestHull:
    @pytest.fixture(autouse=True)
    def beside_the_same_points(self, benchmark: BenchmarkFixture, size: int) -> None:
        benchmark.group = f"{SETS} hulls of {size} points"

    def test_blockstab(self, benchmark: BenchmarkFixture, size: int) -> None:
        benchmark(hull, point_sets(size))

    def test_shapely(self, benchmark: BenchmarkFixture, size: int) -> None:
        benchmark(shapely.convex_hull, shapely.multipoints(point_sets(size).numpy()))

    def test_shapely_from_points(self, benchmark: BenchmarkFixture, size: int) -> None:
        points = point_sets(size).numpy()

        def corners() -> object:
            return shapely.get_coordinates(
                shapely.convex_hull(shapely.multipoints(points)), return_index=True
            )

        benchmark(corners)
