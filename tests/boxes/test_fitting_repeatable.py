"""The same seed and points give the same box whatever else is fitted, and a turn of the world turns it."""

from __future__ import annotations

from dataclasses import fields

import pytest
import torch
from torch import Tensor

from blockstab.boxes.fitting import Fits, MinimumSurface
from tests.seen_boxes import (
    POINTS,
    axis_error_deg,
    boxes_showing,
    fitted,
    random_turns,
    seen_points,
    tensors,
)
from tests.tolerance import COMPANY


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
def test_a_set_gets_the_same_box_within_1e_9_whatever_else_is_in_the_batch(
    size: int, follow: bool, mixed: tuple[Tensor, Tensor, Tensor, Tensor]
) -> None:
    def fit(rows: Tensor) -> Fits:
        return MinimumSurface()(points[rows], count[rows], seed[rows], axis[rows] if follow else None)

    points, count, seed, axis = mixed
    order = torch.randperm(21, generator=torch.Generator().manual_seed(size))
    whole = fit(torch.arange(21))
    for rows in order.split(size):
        for found, expected in zip(tensors(fit(rows)), tensors(whole[rows]), strict=True):
            torch.testing.assert_close(found, expected, rtol=0.0, atol=COMPANY)


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


def test_fits_hold_float64_only(mixed: tuple[Tensor, Tensor, Tensor, Tensor]) -> None:
    points, count, seed, _ = mixed
    fits = MinimumSurface()(points[:2], count[:2], seed[:2])
    assert {values.dtype for values in tensors(fits)} == {torch.float64}
    assert {field.name for field in fields(fits)} == {"boxes", "mean", "variance", "visible_share"}
