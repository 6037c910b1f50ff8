"""Fitting 50 boxes to 2,000 points each, beside the same steps in torch and Open3D's minimal oriented bounding box.

The mean angle between true and found axes stands beside each time.
"""

from __future__ import annotations

import numpy as np
import pytest
import torch
from pytest_benchmark.fixture import BenchmarkFixture
from torch import Tensor

from blockstab.boxes.box import Boxes
from blockstab.boxes.fitting import MinimumSurface
from blockstab.boxes.fitting_in_step import fit_in_step
from blockstab.commands.warm_up import warm_up
from tests.seen_boxes import axis_error_deg, boxes_showing, seen_points

BOXES, POINTS = 50, 2000


@pytest.fixture(scope="module")
def boxes() -> Boxes:
    return boxes_showing(3, BOXES, torch.Generator().manual_seed(0))


@pytest.fixture(scope="module")
def points(boxes: Boxes) -> Tensor:
    return seen_points(boxes, POINTS, torch.Generator().manual_seed(1), 0.002)


@pytest.mark.benchmark(group="50 boxes of 2,000 points")
@pytest.mark.parametrize("follow", [False, True], ids=["free", "with an axis"])
def test_minimum_surface(benchmark: BenchmarkFixture, boxes: Boxes, points: Tensor, follow: bool) -> None:
    count, seed = torch.full((BOXES,), POINTS), torch.arange(BOXES)
    axis = boxes.rotation[:, :, 0] if follow else None
    warm_up()
    fits = benchmark(MinimumSurface(), points, count, seed, axis)
    benchmark.extra_info["axis_error_deg"] = float(axis_error_deg(fits.boxes, boxes).mean())


@pytest.mark.benchmark(group="50 boxes of 2,000 points")
def test_the_steps_in_torch(benchmark: BenchmarkFixture, boxes: Boxes, points: Tensor) -> None:
    count, seed = torch.full((BOXES,), POINTS), torch.arange(BOXES)
    fits = benchmark(fit_in_step, points, count, seed, MinimumSurface())
    benchmark.extra_info["axis_error_deg"] = float(axis_error_deg(fits.boxes, boxes).mean())


@pytest.mark.benchmark(group="50 boxes of 2,000 points")
def test_minimum_volume_of_open3d(benchmark: BenchmarkFixture, boxes: Boxes, points: Tensor) -> None:
    open3d = pytest.importorskip("open3d")
    clouds = [open3d.geometry.PointCloud(open3d.utility.Vector3dVector(p)) for p in np.asarray(points)]
    found = benchmark(lambda: [c.get_minimal_oriented_bounding_box(robust=True) for c in clouds])
    rotation = torch.tensor(np.stack([box.R for box in found]))
    fitted = Boxes(
        boxes.center, rotation * torch.linalg.det(rotation).sign()[:, None, None], boxes.half_extent
    )
    benchmark.extra_info["axis_error_deg"] = float(axis_error_deg(fitted, boxes).mean())


@pytest.mark.benchmark(group="one box of 2,000 points")
def test_minimum_surface_of_one_box(benchmark: BenchmarkFixture, points: Tensor) -> None:
    fits = benchmark(MinimumSurface(), points[:1], torch.tensor([POINTS]), torch.tensor([0]))
    assert len(fits) == 1
