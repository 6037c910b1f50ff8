"""Distances between the histograms of half discs, against histograms that are counted one by one."""

from __future__ import annotations

from collections.abc import Callable
from math import cos, exp, pi, sin

import numpy as np
import pytest
import torch

from blockstab.boundaries.half_discs import ORIENTATIONS
from blockstab.boundaries.histograms import chi_squared_gradient, quadratic_gradient
from tests.tolerance import EXACT, HISTOGRAM, LEARNED

BINS = 32
VALUE = np.arange(BINS) / BINS
COST = 1 - np.exp(-((VALUE[:, None] - VALUE) ** 2) / (2 * 0.1**2))


def quadratic(p: np.ndarray, q: np.ndarray) -> float:
    return float(-(p - q) @ COST @ (p - q) / 2)


def chi_squared(p: np.ndarray, q: np.ndarray) -> float:
    return float(0.5 * sum((a - b) ** 2 / (a + b) for a, b in zip(p, q, strict=True) if a + b > 0))


def counted(bins: np.ndarray, radius: int, distance: Callable[[np.ndarray, np.ndarray], float]) -> np.ndarray:
    """(4, H, W): the distance of the histograms of the two halves of a disc, pixel by pixel."""
    height, width = bins.shape
    padded = np.pad(bins, radius, mode="symmetric")
    row, column = np.mgrid[-radius : radius + 1, -radius : radius + 1]
    disc = row**2 + column**2 <= radius**2
    found = np.zeros((ORIENTATIONS, height, width))
    for k in range(ORIENTATIONS):
        across = column * sin(k * pi / 4) + row * cos(k * pi / 4)
        for i, j in np.ndindex(height, width):
            window = padded[i : i + 2 * radius + 1, j : j + 2 * radius + 1]
            p, q = (
                np.bincount(window[disc & (sign * across > EXACT)], minlength=BINS).astype(float)
                for sign in (1, -1)
            )
            found[k, i, j] = distance(p / p.sum(), q / q.sum())
    return found


def smooth_bins(generator: torch.Generator, height: int = 11, width: int = 15) -> np.ndarray:
    """Bins that differ as those of images do: patches of similar values, of many sizes."""
    coarse = torch.rand(1, 1, 4, 4, generator=generator)
    base = torch.nn.functional.interpolate(coarse, size=(height, width), mode="bicubic")[0, 0]
    grain = 0.1 * torch.randn(height, width, generator=generator)
    return ((base + grain) * BINS).clamp(0, BINS - 1).int().numpy()


@pytest.mark.parametrize("kind", ["smooth", "noise"])
def test_the_quadratic_form_is_that_of_full_histograms(kind: str, generator: torch.Generator) -> None:
    noise = torch.randint(0, BINS, (9, 12), generator=generator).int().numpy()
    bins = smooth_bins(generator) if kind == "smooth" else noise
    assert quadratic_gradient(bins, 4) == pytest.approx(counted(bins, 4, quadratic), abs=HISTOGRAM)


def test_the_distance_of_two_plain_halves_is_the_cost_of_their_values() -> None:
    one, other = np.divmod(np.arange(BINS**2), BINS)
    # One pair below the other, each as high as a disc and each half as wide.
    strips = np.stack([one, other], axis=1).repeat(9, axis=0).repeat(4, axis=1).astype(np.int32)
    found = quadratic_gradient(strips, 4)[2, 4::9, 3:5]
    assert found[:, 0] == pytest.approx(COST[one, other], abs=2 * HISTOGRAM)
    assert np.array_equal(found[:, 0], found[:, 1])
    assert found.max() == pytest.approx(1 - exp(-((31 / 32) ** 2) / 0.02), abs=2 * HISTOGRAM)


@pytest.mark.parametrize("radius", [1, 4, 8])
def test_chi_squared_is_that_of_counted_labels(radius: int, generator: torch.Generator) -> None:
    labels = torch.randint(0, 7, (9, 12), generator=generator).numpy()
    expected = counted(labels, radius, chi_squared)
    assert chi_squared_gradient(labels, radius) == pytest.approx(expected, abs=LEARNED)


def test_halves_without_a_common_label_are_at_distance_one() -> None:
    labels = np.tile(np.repeat([3, 9], 6), (12, 1))
    gradient = chi_squared_gradient(labels, 4)
    assert gradient[2, :, 5:7] == pytest.approx(1.0, abs=LEARNED)
    assert (gradient[2, :, :2] == 0.0).all()
    assert (gradient[0] == 0.0).all()  # above and below, the mixtures are the same


@pytest.mark.parametrize("size", [(1, 1), (10, 7)])
def test_equal_values_are_at_distance_zero(size: tuple[int, int]) -> None:
    plain = np.full(size, 19, np.int32)
    assert (quadratic_gradient(plain, 4) == 0.0).all()
    assert (chi_squared_gradient(plain, 4) == 0.0).all()
