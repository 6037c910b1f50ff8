"""Half discs and ellipses, and sums over them."""

from __future__ import annotations

from itertools import product
from math import cos, pi, sin

import numpy as np
import pytest
import torch

from blockstab.boundaries.half_discs import (
    ORIENTATIONS,
    Line,
    ellipse,
    half_disc_pixels,
    half_discs,
    mirrored,
    sums_over,
)
from tests.tolerance import EXACT

STEPS = ((0, 1), (1, -1), (1, 0), (1, 1))


def pixels_of(lines: tuple[Line, ...], orientation: int) -> set[tuple[int, int]]:
    down, right = STEPS[orientation]
    return {(line.row + n * down, line.column + n * right) for line in lines for n in range(line.pixels)}


def inside(major: float, minor: float, orientation: int) -> dict[tuple[int, int], float]:
    """The pixels of an ellipse, and how far each lies from the long axis, by school trigonometry."""
    angle, found = orientation * pi / 4, {}
    for row, column in product(range(-9, 10), repeat=2):
        along = column * cos(angle) - row * sin(angle)
        across = column * sin(angle) + row * cos(angle)
        if (along / major) ** 2 + (across / minor) ** 2 < 1 + EXACT:
            found[row, column] = across
    return found


def test_the_halves_of_a_small_disc_are_those_drawn_by_hand() -> None:
    left, right = half_discs(2, 2)
    beside = {(-1, 1), (0, 1), (1, 1), (0, 2)}
    assert {frozenset(pixels_of(half, 2)) for half in (left, right)} == {
        frozenset(beside),
        frozenset((row, -column) for row, column in beside),
    }


@pytest.mark.parametrize("orientation", range(ORIENTATIONS))
@pytest.mark.parametrize("radius", [1, 4, 8])
def test_the_line_through_the_centre_parts_a_disc(radius: int, orientation: int) -> None:
    disc = inside(radius, radius, orientation)
    for sign in (1, -1):
        half = {pixel for pixel, across in disc.items() if across * sign > EXACT}
        assert len(half) == half_disc_pixels(radius, orientation)
        assert half in [pixels_of(lines, orientation) for lines in half_discs(radius, orientation)]


@pytest.mark.parametrize("orientation", range(ORIENTATIONS))
@pytest.mark.parametrize(("major", "minor"), [(4, 1), (8, 2), (3, 3)])
def test_an_ellipse_lies_along_its_orientation(major: int, minor: int, orientation: int) -> None:
    lines = ellipse(major, minor, orientation)
    expected = inside(major, minor, orientation)
    assert pixels_of(lines, orientation) == set(expected)
    for line in lines:
        assert abs(line.distance) == pytest.approx(abs(expected[line.row, line.column]), abs=EXACT)


@pytest.mark.parametrize("orientation", range(ORIENTATIONS))
@pytest.mark.parametrize("size", [(1, 1), (3, 8), (11, 6)])
def test_sums_are_those_over_every_single_pixel(
    size: tuple[int, int], orientation: int, generator: torch.Generator
) -> None:
    padded = torch.randint(-50, 50, (size[0] + 8, size[1] + 8), generator=generator).numpy()
    halves = half_discs(4, orientation)
    for found, lines in zip(sums_over(padded, 4, orientation, halves), halves, strict=True):
        expected = np.zeros(size, np.int64)
        for row, column in pixels_of(lines, orientation):
            expected += padded[4 + row : 4 + row + size[0], 4 + column : 4 + column + size[1]]
        assert np.array_equal(found, expected)


@pytest.mark.parametrize("dtype", [np.uint8, np.float32])
def test_beyond_the_rim_an_image_is_mirrored_as_often_as_needed(dtype: type) -> None:
    image = np.array([[[1, 2], [3, 4]]], dtype)
    upper, lower = [2, 2, 1, 1, 2, 2, 1, 1], [4, 4, 3, 3, 4, 4, 3, 3]
    expected = [[lower, lower, upper, upper, lower, lower, upper, upper]]
    assert mirrored(image, 3).tolist() == expected
    assert mirrored(image[:, :1, :1], 2).tolist() == [[[1] * 5] * 5]
