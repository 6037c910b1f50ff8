"""Gradients smoothed along edges."""

from __future__ import annotations

from math import cos, pi, sin

import numpy as np
import pytest
import torch

from blockstab.boundaries.smoothing import smoothed
from tests.tolerance import EXACT, LEARNED

ORIENTATIONS = range(4)


def across(height: int, width: int, orientation: int) -> np.ndarray:
    """(H, W) distance of each pixel from the line along the orientation through pixel 0, 0."""
    row, column = np.mgrid[:height, :width]
    return column * sin(orientation * pi / 4) + row * cos(orientation * pi / 4)


@pytest.mark.parametrize("major", [4, 8])
def test_the_value_is_that_of_a_parabola_fitted_by_least_squares(
    major: int, generator: torch.Generator
) -> None:
    gradients = torch.rand(4, 21, 21, generator=generator).numpy() + np.float32(1.0)
    found = smoothed(gradients, major)[:, 10, 10]
    row, column = np.mgrid[-10:11, -10:11]
    for k in ORIENTATIONS:
        along = column * cos(k * pi / 4) - row * sin(k * pi / 4)
        distance = column * sin(k * pi / 4) + row * cos(k * pi / 4)
        window = (along / major) ** 2 + (distance / (major / 4)) ** 2 < 1 + EXACT
        powers = np.stack([np.ones(window.sum()), distance[window], distance[window] ** 2], axis=1)
        fitted = np.linalg.lstsq(powers, gradients[k][window].astype(np.float64), rcond=None)[0]
        assert found[k] == pytest.approx(fitted[0], abs=LEARNED)


@pytest.mark.parametrize("major", [4, 8])
def test_a_straight_ridge_keeps_its_profile(major: int) -> None:
    away = [across(40, 40, k) - across(40, 40, k)[20, 20] for k in ORIENTATIONS]
    ridge = (4.0 + 0.01 * np.square(away)).astype(np.float32)
    inner = np.s_[:, major:-major, major:-major]
    assert smoothed(ridge, major)[inner] == pytest.approx(ridge[inner], abs=LEARNED)


def test_a_line_survives_in_its_own_orientation_only() -> None:
    line = np.zeros((4, 21, 21), np.float32)
    line[:, :, 10] = 1.0
    kept = smoothed(line, 4)[:, 10, 10]
    assert kept[2] == pytest.approx(1.0, abs=LEARNED)
    assert kept[[0, 1, 3]].max() < 0.25


def test_nothing_falls_below_zero(generator: torch.Generator) -> None:
    spikes = (torch.rand(2, 4, 30, 30, generator=generator) > 0.98).float().numpy()
    assert smoothed(spikes, 8).min() == 0.0


@pytest.mark.parametrize("size", [(1, 1), (2, 9)])
def test_a_plain_image_of_any_size_stays_plain(size: tuple[int, int]) -> None:
    plain = np.full((3, 4, *size), 0.4, np.float32)
    found = smoothed(plain, 4)
    assert found.dtype == np.float32
    assert found == pytest.approx(plain, abs=LEARNED)
