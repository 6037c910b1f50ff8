"""Boxes of minimum surface distance: recovered, exact without noise, whole when points are poor, and repeatable."""

from __future__ import annotations

import math
from dataclasses import fields

import pytest
import torch
from torch import Tensor

from blockstab.boxes.box import MIN_HALF_EXTENT, Boxes, checked
from blockstab.boxes.fitting import PAPER_TOLERANCE, Fits, MinimumSurface, PlaneTolerance, judged
from tests.seen_boxes import (
    axis_error_deg,
    boxes_showing,
    half_extent_error,
    on_faces,
    random_turns,
    seen_points,
)
from tests.tolerance import EXACT

POINTS = 2000
UP = torch.tensor([[0.0, 1.0, 0.0]], dtype=torch.float64)


def fitted(points: Tensor, fitter: MinimumSurface | None = None, axis: Tensor | None = None) -> Fits:
    """Fit to all points (N, P, 3), set k with seed k."""
    n = len(points)
    count = torch.full((n,), points.shape[1])
    return (fitter or MinimumSurface())(points, count, torch.arange(n), axis)


def tensors(fits: Fits) -> list[Tensor]:
    boxes = fits.boxes
    return [boxes.center, boxes.rotation, boxes.half_extent, fits.mean, fits.variance, fits.visible_share]


@pytest.mark.parametrize("noise_m", [0.0015, 0.003])
@pytest.mark.parametrize("faces", [2, 3])
def test_two_faces_are_enough_for_axes_within_half_a_degree(
    faces: int, noise_m: float, generator: torch.Generator
) -> None:
    boxes = boxes_showing(faces, 60, generator)
    fits = fitted(seen_points(boxes, POINTS, generator, noise_m))
    error = axis_error_deg(fits.boxes, boxes)
    assert float(error.mean()) < 0.2
    assert float(error.max()) < 1.0
    assert float(half_extent_error(fits.boxes, boxes).abs().max()) < 0.005
    assert float(half_extent_error(fits.boxes, boxes).abs().mean()) < 0.0015


@pytest.mark.parametrize("noise_m", [0.0015, 0.003])
def test_one_face_is_enough_for_the_directions_of_its_sides(
    noise_m: float, generator: torch.Generator
) -> None:
    boxes = boxes_showing(1, 60, generator)
    fits = fitted(seen_points(boxes, POINTS, generator, noise_m))
    error = axis_error_deg(fits.boxes, boxes)
    assert float(error.mean()) < 0.7  # a trimmed rectangle tells small turns badly apart
    assert float(error.quantile(0.9)) < 1.5
    seen = half_extent_error(fits.boxes, boxes).abs().sort(dim=1).values[:, :2]
    assert float(seen.max()) < 0.005
    assert float(fits.boxes.half_extent.amin(dim=1).max()) < 0.015


def test_the_top_of_a_book_is_fitted_flat_with_its_own_sides(generator: torch.Generator) -> None:
    cos, sin = math.cos(0.4), math.sin(0.4)
    turn = torch.tensor([[cos, 0.0, sin], [0.0, 1.0, 0.0], [-sin, 0.0, cos]], dtype=torch.float64)
    books = Boxes(
        torch.tensor([[0.1, -0.5, -0.7]], dtype=torch.float64).expand(20, -1),
        turn.expand(20, -1, -1),
        torch.tensor([[0.08, 0.01, 0.12]], dtype=torch.float64).expand(20, -1),
    )
    place = 2 * torch.rand(20, POINTS, 3, generator=generator, dtype=torch.float64) - 1
    top = on_faces(books, torch.full((20, POINTS), 2), place)
    top = top * (1 + 0.001 * torch.randn(20, POINTS, 1, generator=generator, dtype=torch.float64))
    fits = fitted(top)
    assert float(axis_error_deg(fits.boxes, books).mean()) < 2.0  # a trimmed rectangle tells small turns badly apart
    assert float(axis_error_deg(fits.boxes, books).max()) < 4.5
    assert float(half_extent_error(fits.boxes, books)[:, [0, 2]].abs().max()) < 0.004
    assert float(fits.boxes.half_extent.amin(dim=1).max()) < 0.006
    up = (fits.boxes.rotation.transpose(1, 2) @ UP[0]).abs().amax(dim=1)
    assert float(up.min()) > math.cos(math.radians(0.5))


@pytest.mark.parametrize("faces", [2, 3])
def test_without_noise_the_box_is_exact(faces: int, generator: torch.Generator) -> None:
    boxes = boxes_showing(faces, 20, generator)
    corners = boxes.corners()
    onto = torch.cat([seen_points(boxes, POINTS - 600, generator), corners.repeat(1, 75, 1)], dim=1)
    fits = fitted(onto[:, torch.randperm(POINTS, generator=generator)])
    assert float(axis_error_deg(fits.boxes, boxes).max()) < 1e-4
    assert float(half_extent_error(fits.boxes, boxes).abs().max()) < 1e-6
    assert float((fits.boxes.center - boxes.center).norm(dim=1).max()) < 1e-6
    assert float(fits.mean.max()) < 1e-6


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


def test_a_single_point_gets_the_thinnest_box_around_it() -> None:
    point = torch.tensor([[[0.1, 0.2, -1.0]]], dtype=torch.float64)
    boxes = fitted(point).boxes
    assert float((boxes.center - point[:, 0]).abs().max()) < EXACT
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


@pytest.fixture(scope="module")
def mixed() -> tuple[Tensor, Tensor, Tensor, Tensor]:
    """Points, counts, seeds and axes of sets that take every path: many and few points, one face to three."""
    generator = torch.Generator().manual_seed(11)
    parts = [seen_points(boxes_showing(k, 7, generator), POINTS, generator, 0.002) for k in (1, 2, 3)]
    points = torch.cat(parts)
    points[3, 50:] = points[3, :1].clone()
    count = torch.randint(20, POINTS + 1, (21,), generator=generator)
    count[[0, 7, 14, 20]] = POINTS
    count[[1, 8]] = torch.tensor([1, 5])
    seed = torch.randint(-(2**62), 2**62, (21,), generator=generator)
    axis = torch.nn.functional.normalize(torch.randn(21, 3, generator=generator, dtype=torch.float64), dim=1)
    return points, count, seed, axis


@pytest.mark.parametrize("follow", [False, True], ids=["free", "with an axis"])
@pytest.mark.parametrize("size", [1, 2, 3, 5, 21])
def test_a_set_gets_the_same_bits_whatever_else_is_in_the_batch(
    size: int, follow: bool, mixed: tuple[Tensor, Tensor, Tensor, Tensor]
) -> None:
    def fit(rows: Tensor) -> Fits:
        return MinimumSurface()(points[rows], count[rows], seed[rows], axis[rows] if follow else None)

    points, count, seed, axis = mixed
    order = torch.randperm(21, generator=torch.Generator().manual_seed(size))
    whole = fit(torch.arange(21))
    for rows in order.split(size):
        assert same_bits(fit(rows), whole[rows])


def same_bits(a: Fits, b: Fits) -> bool:
    return all(torch.equal(x, y) for x, y in zip(tensors(a), tensors(b), strict=True))


def test_rows_past_the_count_change_no_bit(mixed: tuple[Tensor, Tensor, Tensor, Tensor]) -> None:
    points, count, seed, _ = mixed
    spoiled = points.clone()
    spoiled[torch.arange(POINTS) >= count[:, None]] = 7.0
    assert same_bits(MinimumSurface()(spoiled, count, seed), MinimumSurface()(points, count, seed))


def test_another_seed_gives_another_fit_of_the_same_box(generator: torch.Generator) -> None:
    box = boxes_showing(3, 1, generator)
    points = seen_points(box, POINTS, generator, 0.003).expand(40, -1, -1)
    fits = fitted(points)
    assert len(fits.boxes.center.unique(dim=0)) > 20
    assert float(axis_error_deg(fits.boxes, box[[0] * 40]).max()) < 0.5


@pytest.mark.parametrize("faces", [2, 3])
def test_turning_the_points_about_the_camera_turns_the_box(faces: int, generator: torch.Generator) -> None:
    points = seen_points(boxes_showing(faces, 20, generator), POINTS, generator, 0.002)
    turn = random_turns(1, generator)[0]
    plain, turned = fitted(points), fitted(points @ turn.T)
    assert float(axis_error_deg(turned.boxes, plain.boxes.rotated(turn)).max()) < 1e-6
    assert float((turned.boxes.center - plain.boxes.center @ turn.T).abs().max()) < 1e-8
    assert float((turned.mean - plain.mean).abs().max()) < 1e-8


@pytest.mark.parametrize("faces", [1, 2, 3])
def test_a_given_axis_becomes_an_axis_of_the_box_exactly(faces: int, generator: torch.Generator) -> None:
    boxes = boxes_showing(faces, 30, generator)
    points = seen_points(boxes, POINTS, generator, 0.003)
    tilted = torch.randn(30, 3, generator=generator, dtype=torch.float64)
    near = torch.nn.functional.normalize(boxes.rotation[..., 0] + 0.03 * tilted, dim=1)
    for axis in (near, torch.nn.functional.normalize(tilted, dim=1)):
        found = fitted(points, axis=axis).boxes
        likeness = (found.rotation.transpose(1, 2) @ axis[..., None]).abs()[..., 0].amax(dim=1)
        assert float(likeness.min()) > 1 - EXACT
        checked(found)


def test_the_right_axis_brings_the_other_two_closer_to_the_truth(generator: torch.Generator) -> None:
    boxes = boxes_showing(2, 60, generator)
    points = seen_points(boxes, 300, generator, 0.006)
    free, follow = fitted(points), fitted(points, axis=boxes.rotation[..., 0])
    assert float(axis_error_deg(follow.boxes, boxes).mean()) < float(axis_error_deg(free.boxes, boxes).mean())


def test_the_box_of_least_surface_distance_is_chosen_among_the_restarts(generator: torch.Generator) -> None:
    boxes = boxes_showing(3, 40, generator)
    points = seen_points(boxes, 256, generator, 0.004)
    once = fitted(points, MinimumSurface(restarts=1, samples=1))
    often = fitted(points, MinimumSurface(restarts=15, samples=10))
    assert float(often.mean.mean()) < float(once.mean.mean())
    assert float(axis_error_deg(often.boxes, boxes).mean()) < float(axis_error_deg(once.boxes, boxes).mean())


def test_the_tolerance_grows_with_the_square_of_the_distance() -> None:
    points = torch.tensor([[0.0, 0.0, 0.0], [0.0, 0.6, 0.8], [0.0, 0.0, -2.0]], dtype=torch.float64)
    found = PlaneTolerance(floor_m=0.003, per_square_m=0.0035).at(points)
    assert found.tolist() == pytest.approx([0.003, 0.0065, 0.017], abs=EXACT)


def test_the_tolerance_of_the_paper_is_two_centimetres_everywhere() -> None:
    points = torch.tensor([[0.0, 0.0, 0.1], [0.0, 0.0, 5.0]], dtype=torch.float64)
    assert PAPER_TOLERANCE.at(points).tolist() == [0.02, 0.02]


def test_noise_that_grows_with_distance_is_met_better_by_a_tolerance_that_does(
    generator: torch.Generator,
) -> None:
    near = boxes_showing(3, 40, generator)
    small = Boxes(near.center, near.rotation, near.half_extent * 0.4)  # 2.4 to 12 cm: 2 cm blur their edges
    points = seen_points(small, POINTS, generator, 0.0015)
    paper = fitted(points, MinimumSurface(tolerance=PAPER_TOLERANCE))
    assert float(axis_error_deg(fitted(points).boxes, small).mean()) < float(
        axis_error_deg(paper.boxes, small).mean()
    )


def test_mean_and_variance_are_those_of_the_distance_to_the_nearest_face() -> None:
    cube = Boxes(
        torch.tensor([[0.0, 0.0, -1.0]], dtype=torch.float64),
        torch.eye(3, dtype=torch.float64)[None],
        torch.full((1, 3), 0.1, dtype=torch.float64),
    )
    # In the middle, on a face, 3 and 4 cm past an edge, and one that does not count.
    points = torch.tensor(
        [[[0.0, 0.0, -1.0], [0.1, 0.02, -1.0], [0.13, 0.14, -1.0], [9.0, 9.0, 9.0]]], dtype=torch.float64
    )
    fits = judged(cube, points, torch.tensor([[True, True, True, False]]))
    assert float(fits.mean[0]) == pytest.approx(0.05, abs=EXACT)
    assert float(fits.variance[0]) == pytest.approx((0.05**2 + 0.05**2 + 0.0) / 3, abs=EXACT)


def test_no_sets_give_no_fits() -> None:
    none = torch.zeros(0, POINTS, 3, dtype=torch.float64)
    fits = MinimumSurface()(none, torch.zeros(0, dtype=torch.int64), torch.zeros(0, dtype=torch.int64))
    assert len(fits) == 0
    assert len(fits.boxes) == 0


def test_fits_hold_float64_only(mixed: tuple[Tensor, Tensor, Tensor, Tensor]) -> None:
    points, count, seed, _ = mixed
    fits = MinimumSurface()(points[:2], count[:2], seed[:2])
    assert {values.dtype for values in tensors(fits)} == {torch.float64}
    assert {field.name for field in fields(fits)} == {"boxes", "mean", "variance", "visible_share"}


@pytest.mark.parametrize("wrong", [0, 11])
def test_a_set_with_too_few_or_too_many_points_is_named(wrong: int) -> None:
    points = torch.zeros(3, 10, 3, dtype=torch.float64)
    with pytest.raises(ValueError, match=f"at least 1 and at most 10 points, but set 2 says it has {wrong}"):
        MinimumSurface()(points, torch.tensor([10, 3, wrong]), torch.zeros(3, dtype=torch.int64))


@pytest.mark.parametrize("shape", [(10, 3), (3, 10, 2)])
def test_points_of_another_shape_are_refused(shape: tuple[int, ...]) -> None:
    with pytest.raises(ValueError, match=r"needs points \(N, P, 3\) and counts \(N,\), but got"):
        MinimumSurface()(torch.zeros(shape), torch.ones(3, dtype=torch.int64), torch.zeros(3).long())
