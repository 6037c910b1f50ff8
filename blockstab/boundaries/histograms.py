"""Distances between the histograms of the two sides of each pixel."""

from __future__ import annotations

from functools import cache

import numpy as np

from blockstab.boundaries.colors import BINS
from blockstab.boundaries.half_discs import (
    ORIENTATIONS,
    Array,
    half_disc_pixels,
    half_discs,
    mirrored,
    sums_over,
)

_LIKENESS = 0.1  # standard deviation of the similarity of two values, both 0 to 1
_FEATURES = 13  # of the kernel's 32; without the others no distance changes by more than 0.001
_LARGEST = 2**15 - 1  # whole number of 16 bits
_MOST = 128  # more than the pixels of a half disc


def quadratic_gradient(bins: Array, radius: int) -> Array:
    """The quadratic-form distance between the histograms of two half discs, at every pixel and orientation.

    For histograms p and q, each of sum 1, it is (p - q)' S (p - q) / 2, where S holds the similarity
    exp(-d^2 / (2 0.1^2)) of any two bins whose values differ by d; as the sums are equal, one may as well take the
    cost 1 - S and turn the sign. It is 0 for equal halves, and 1 for a black one and a white one.

    S is a positive kernel, so this is half the squared distance between the mean features of the halves (Gretton et
    al. 2012), where the features of a bin are its row in a square root of S, of which few columns matter. They are
    rounded to whole numbers: then sums over halves are exact, and fast, and no distance is off by more than 0.002.

    Args:
        bins: (H, W) int32, 0 to 31.
        radius: of the disc, pixels. Beyond 4 the features get coarse, because sums must stay within 16 bits.

    Returns:
        (4, H, W) float32.
    """
    padded = mirrored(bins, radius)
    features, unit = _features(radius)
    distance = np.zeros((ORIENTATIONS, *bins.shape), np.float32)
    for feature in features:
        image = np.take(feature, padded)
        for k in range(ORIENTATIONS):
            one, other = sums_over(image, radius, k, half_discs(radius, k))
            one -= other
            difference = one.astype(np.float32)
            difference *= difference
            distance[k] += difference
    for k in range(ORIENTATIONS):
        distance[k] /= 2.0 * (unit * half_disc_pixels(radius, k)) ** 2
    return distance


def chi_squared_gradient(labels: Array, radius: int) -> Array:
    """The chi-squared distance between the histograms of two half discs, at every pixel and orientation.

    For histograms p and q, each of sum 1, it is half the sum of (p - q)^2 / (p + q): 0 for equal halves, 1 for halves
    without a common label.

    Args:
        labels: (H, W) integers.
        radius: of the disc, at most 8 pixels.

    Returns:
        (4, H, W) float32.
    """
    padded = mirrored(labels, radius)
    distance = np.zeros((ORIENTATIONS, *labels.shape), np.float32)
    terms = _chi_squared_terms()
    for label in np.unique(labels):
        image = (padded == label).astype(np.int16)
        for k in range(ORIENTATIONS):
            one, other = sums_over(image, radius, k, half_discs(radius, k))
            other *= _MOST
            other += one
            distance[k] += np.take(terms, other)
    for k in range(ORIENTATIONS):
        distance[k] /= 2.0 * half_disc_pixels(radius, k)
    return distance


@cache
def _chi_squared_terms() -> Array:
    """(_MOST^2,) float32: (m - n)^2 / (m + n), or 0 for 0 and 0, at m + n times `_MOST`."""
    count = np.arange(_MOST, dtype=np.float32)
    terms: Array = (count - count[:, None]) ** 2 / np.maximum(count + count[:, None], 1.0)
    return terms.flatten()


@cache
def _features(radius: int) -> tuple[Array, float]:
    """(13, 32) int16: each feature of the kernel in each bin; and what stands for 1 in them."""
    value = np.arange(BINS) / BINS
    kernel = np.exp(-((value[:, None] - value) ** 2) / (2 * _LIKENESS**2))
    eigenvalues, eigenvectors = np.linalg.eigh(kernel)
    features = (eigenvectors[:, -_FEATURES:] * np.sqrt(eigenvalues[-_FEATURES:])).T
    spread = float(np.ptp(features, axis=1).max())
    # Rounding may add 1 to a spread.
    unit = (_LARGEST / max(half_disc_pixels(radius, k) for k in range(ORIENTATIONS)) - 1.0) / spread
    return np.rint(features * unit).astype(np.int16), unit
