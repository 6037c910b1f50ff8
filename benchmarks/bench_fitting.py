"""Fitting 50 boxes to 2,000 points each, beside Open3D's minimal oriented bounding box."""

from __future__ import annotations

import numpy as np
import pytest
import torch
from pytest_benchmark.fixture import BenchmarkFixture
from torch import Tensor

from blockstab.boxes.fitting import MinimumSurface
from tests.seen_boxes import boxes_showing, seen_points

BOXES, POINTS = 50, 2000


@pytest.fixture(scope="module")
def points() -> Tensor:
    generator = torch.Generator().manual_seed(0)
    return seen_points(boxes_showing(3, BOXES, generator), POINTS, generator, 0.002)


@pytest.mark.benchmark(group="50 boxes of 2,000 points")
@pytest.mark.parametrize("follow", [False, True], ids=["free", "with an axis"])
def test_minimum_surface(benchmark: BenchmarkFixture, points: Tensor, follow: bool) -> None:
    count, seed = torch.full((BOXES,), POINTS), torch.arange(BOXES)
    axis = torch.tensor([[0.0, 1.0, 0.0]], dtype=torch.float64).expand(BOXES, -1) if follow else None
    fits = benchmark(MinimumSurface(), points, count, seed, axis)
    assert len(fits) == BOXES


@pytest.mark.benchmark(group="50 boxes of 2,000 points")
def test_minimum_volume_of_open3d(benchmark: BenchmarkFixture, points: Tensor) -> None:
    open3d = pytest.importorskip("open3d")
    clouds = [open3d.geometry.PointCloud(open3d.utility.Vector3dVector(p)) for p in np.asarray(points)]

    def fit() -> list[object]:
        return [cloud.get_minimal_oriented_bounding_box(robust=True) for cloud in clouds]

    assert len(benchmark(fit)) == BOXES


@pytest.mark.benchmark(group="one box of 2,000 points")
def test_minimum_surface_of_one_box(benchmark: BenchmarkFixture, points: Tensor) -> None:
    fits = benchmark(MinimumSurface(), points[:1], torch.tensor([POINTS]), torch.tensor([0]))
    assert len(fits) == 1
