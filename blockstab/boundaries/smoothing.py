"""Oriented gradients smoothed along the edges that they show, and hardly across (Martin, Fowlkes and Malik 2004)."""

from __future__ import annotations

from functools import cache

import numpy as np

from blockstab.boundaries.half_discs import ORIENTATIONS, Array, Line, ellipse, mirrored, sums_over


def smoothed(gradients: Array, major: int) -> Array:
    """Replace each value by that of a parabola fitted around it (Savitzky and Golay 1964).

    The parabola runs across the edge and is constant along it. It is fitted by least squares to the pixels in an
    ellipse whose longer axis lies along the edge. Beyond the rim the image is mirrored.

    Args:
        gradients: (..., 4, H, W) float32, one orientation after the other.
        major: the longer half axis, pixels; the shorter one is a quarter of it.

    Returns:
        (..., 4, H, W) float32, nowhere below 0.
    """
    height, width = gradients.shape[-2:]
    padded = mirrored(gradients.reshape(-1, ORIENTATIONS, height, width), major)
    fitted = np.zeros((len(padded), ORIENTATIONS, height, width), np.float32)
    for n, k in np.ndindex(fitted.shape[:2]):
        lines, weights = _weighted_lines(major, k)
        for total, weight in zip(sums_over(padded[n, k], major, k, lines), weights, strict=True):
            total *= weight
            fitted[n, k] += total
    return np.maximum(fitted, 0.0, out=fitted).reshape(gradients.shape)


@cache
def _weighted_lines(major: int, orientation: int) -> tuple[list[list[Line]], list[float]]:
    """Lines of the ellipse, and what their pixels count in the value of the parabola at the centre."""
    lines = ellipse(major, major // 4, orientation)
    distance = np.array([line.distance for line in lines])
    pixels = np.array([line.pixels for line in lines])
    powers = distance[:, None] ** np.arange(3)
    weights = powers @ np.linalg.pinv(powers.T @ (pixels[:, None] * powers))[0]
    some = np.flatnonzero(np.abs(weights) > 1e-12)  # in a narrow ellipse, only the line through the centre
    return [[lines[n]] for n in some], [float(weights[n]) for n in some]
