"""Boxes are whole, and hold their points, however few, equal or scattered those are."""

from __future__ import annotations

import pytest
import torch
from torch import Tensor

from blockstab.boxes.box import MIN_HALF_EXTENT, checked
from blockstab.boxes.fitting import MinimumSurface
from tests.seen_boxes import (
    POINTS,
    axis_error_deg,
    boxes_showing,
    fitted,
    seen_points,
    tensors,
)
from tests.tolerance import EXACT

UP = torch.tensor([[0.0, 1.0, 0.0]], dtype=torch.float64)


def test_at_least_ninety_five_percent_of_the_points_are_enclosed(generator: torch.Generator) -> None:
    boxes = boxes_showing(3, 30, generator)
    points = seen_points(boxes, POINTS, generator, 0.003)
    stray = torch.rand(30, POINTS, 1, generator=generator) < 0.1
    step = 0.2 * torch.randn(30, POINTS, 3, generator=generator, dtype=torch.float64)
    points = torch.where(stray, points + step, points)
    count = torch.randint(1, POINTS + 1, (30,), generator=generator)
    fits = MinimumSurface()(points, count, torch.arange(30))
    outside = (fits.boxes.local(points).abs() > fits.boxes.half_extent[:, None] + EXACT).any(dim=-1)
    outside &= torch.arange(POINTS) < count[:, None]
    assert bool((outside.sum(dim=1) <= 0.05 * count).all())


def test_without_outliers_allowed_every_point_is_enclosed(generator: torch.Generator) -> None:
    points = seen_points(boxes_showing(3, 10, generator), 500, generator, 0.003)
    boxes = fitted(points, MinimumSurface(outlier_share=0.0)).boxes
    assert bool((boxes.local(points).abs() <= boxes.half_extent[:, None] + EXACT).all())


@pytest.mark.parametrize("axis", [None, UP], ids=["free", "upright"])
@pytest.mark.parametrize(
    "points",
    [
        [[0.1, 0.2, -1.0]],
        [[0.1, 0.2, -1.0], [0.15, 0.2, -1.0]],
        [[0.1, 0.2, -1.0], [0.15, 0.2, -1.0], [0.1, 0.3, -1.1]],
        [[0.1, 0.2, -1.0]] * 300,
        [[0.1, 0.2, -1.0]] * 150 + [[0.2, 0.2, -1.0]] * 150,
        [[0.001 * k, 0.0, -1.0] for k in range(300)],
        [[0.001 * k, 0.002 * k, -1.0 + 0.0005 * k] for k in range(300)],
        [[0.01 * j, 0.01 * k, -1.0] for j in range(20) for k in range(10)],
        [[0.0, 0.0, 0.0]] * 20,
    ],
    ids=[
        "one",
        "two",
        "three",
        "equal",
        "two places",
        "along x",
        "on a line",
        "on a lattice",
        "in the camera",
    ],
)
def test_poor_points_give_a_whole_box(points: list[list[float]], axis: Tensor | None) -> None:
    given = torch.tensor([points], dtype=torch.float64)
    given = given[:, torch.randperm(given.shape[1], generator=torch.Generator().manual_seed(1))]
    fits = fitted(given, axis=axis)
    checked(fits.boxes)
    assert all(bool(values.isfinite().all()) for values in tensors(fits))
    outside = (fits.boxes.local(given).abs() > fits.boxes.half_extent[:, None] + EXACT).any(dim=-1)
    assert int(outside.sum()) <= 0.05 * len(points)


def test_a_single_point_is_the_near_corner_of_the_thinnest_box() -> None:
    point = torch.tensor([[[0.1, 0.2, -1.0]]], dtype=torch.float64)
    boxes = fitted(point).boxes
    assert float((boxes.corners()[0] - point[0]).norm(dim=-1).min()) < EXACT
    assert float(boxes.center.norm()) > float(point.norm())
    assert boxes.half_extent.tolist() == [[MIN_HALF_EXTENT] * 3]


@pytest.mark.parametrize(("pattern", "bound_deg"), [("each ten times", 0.6), ("half of them equal", 1.0)])
def test_points_given_more_than_once_do_not_ruin_the_fit(
    pattern: str, bound_deg: float, generator: torch.Generator
) -> None:
    boxes = boxes_showing(3, 60, generator)
    points = seen_points(boxes, POINTS, generator, 0.002)
    if pattern == "each ten times":
        points = points[:, : POINTS // 10].repeat(1, 10, 1)
    else:
        points[:, : POINTS // 2] = points[:, :1].clone()
    points = points[:, torch.randperm(POINTS, generator=generator)]
    assert float(axis_error_deg(fitted(points).boxes, boxes).mean()) < bound_deg


def test_no_sets_give_no_fits() -> None:
    none = torch.zeros(0, POINTS, 3, dtype=torch.float64)
    fits = MinimumSurface()(none, torch.zeros(0, dtype=torch.int64), torch.zeros(0, dtype=torch.int64))
    assert len(fits) == 0
    assert len(fits.boxes) == 0


@pytest.mark.parametrize("wrong", [0, 11])
def test_a_set_with_too_few_or_too_many_points_is_named(wrong: int) -> None:
    points = torch.zeros(3, 10, 3, dtype=torch.float64)
    with pytest.raises(ValueError, match=f"1 to 10 points, but set 2 says it has {wrong}"):
        MinimumSurface()(points, torch.tensor([10, 3, wrong]), torch.zeros(3, dtype=torch.int64))


@pytest.mark.parametrize("shape", [(10, 3), (3, 10, 2)])
def test_points_of_another_shape_are_refused(shape: tuple[int, ...]) -> None:
    with pytest.raises(ValueError, match=r"needs points \(N, P, 3\) and counts \(N,\), but got"):
        MinimumSurface()(torch.zeros(shape), torch.ones(3, dtype=torch.int64), torch.zeros(3).long())
