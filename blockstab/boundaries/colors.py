"""Brightness and colour as Pb compares them: blurred, in Lab, in 32 bins (Martin, Fowlkes and Malik 2004)."""

from __future__ import annotations

import numpy as np

from blockstab.boundaries.half_discs import Array, mirrored

BINS = 32

_BLUR_PX, _BLUR_REACH_PX = 2.0, 6  # standard deviation, and how far the weights go
_BLUR_SUM = 2048  # of the weights, which are whole numbers; with it no sum exceeds 32 bits
_AB_RANGE = (-73.0, 95.0)
_XYZ = (  # of linear RGB with the primaries of ITU-R BT.709; divided by the sum of its row, so that white is 1, 1, 1
    (0.412391, 0.357584, 0.180481),
    (0.212639, 0.715169, 0.072192),
    (0.019331, 0.119195, 0.950532),
)
_DARK = 6.0 / 29.0  # cube root of the share of white below which CIE 1976 makes the root a line


def blurred(color: Array) -> Array:
    """Blur an image by 13 x 13 Gaussian weights of standard deviation 2 pixels.

    Args:
        color: (H, W, 3) uint8.

    Returns:
        (3, H, W) float32, 0 to 1.
    """
    offset = np.arange(-_BLUR_REACH_PX, _BLUR_REACH_PX + 1)
    weight = np.exp(-(offset**2) / (2 * _BLUR_PX**2))
    whole = np.rint(weight / weight.sum() * _BLUR_SUM).astype(np.int32)
    whole[_BLUR_REACH_PX] += _BLUR_SUM - whole.sum()
    height, width = color.shape[:2]
    image = mirrored(color.transpose(2, 0, 1), _BLUR_REACH_PX).astype(np.int32)
    planes = []
    for plane in image:  # one after the other, they stay in the cache
        across = sum(w * plane[:, k : k + width] for k, w in enumerate(whole))
        planes.append(sum(w * across[k : k + height] for k, w in enumerate(whole)))
    return np.stack(planes).astype(np.float32) / np.float32(255 * _BLUR_SUM**2)


def halved(image: Array) -> Array:
    """(C, ceil(H / 2), ceil(W / 2)) means of 2 x 2 pixels, from (C, H, W); a last odd row or column counts twice."""
    padded = np.pad(image, [(0, 0), (0, image.shape[1] % 2), (0, image.shape[2] % 2)], mode="edge")
    top, bottom = padded[:, ::2], padded[:, 1::2]
    # Added corner to corner, the mean of an image turned by a right angle is the turned mean, to the last bit.
    total: Array = (top[..., ::2] + bottom[..., 1::2]) + (top[..., 1::2] + bottom[..., ::2])
    return total / np.float32(4.0)


def brightness_bins(rgb: Array) -> Array:
    """(H, W) int32, 0 to 31: the lightness L of Lab, whose 0 to 100 is cut into 32 bins.

    Args:
        rgb: (3, H, W) float32, 0 to 1; raised to the power of 2.5 it is taken as linear.
    """
    return _bin(1.16 * _root(_share_of_white(_linear(rgb), 1)) - 0.16)


def color_bins(rgb: Array) -> tuple[Array, Array]:
    """(H, W) int32, 0 to 31, each: a and b of Lab, whose -73 to 95 is cut into 32 bins; else like brightness."""
    linear = _linear(rgb)
    x, y, z = (_root(_share_of_white(linear, k)) for k in range(3))
    low, high = _AB_RANGE
    return _bin((500.0 * (x - y) - low) / (high - low)), _bin((200.0 * (y - z) - low) / (high - low))


def _linear(rgb: Array) -> Array:
    """The power of 2.5."""
    return np.square(rgb) * np.sqrt(rgb)


def _share_of_white(linear: Array, k: int) -> Array:
    """(H, W) one of the tristimulus values X, Y, Z, 1 for white."""
    red, green, blue = _XYZ[k]
    share: Array = red * linear[0] + green * linear[1] + blue * linear[2]
    return share / (red + green + blue)


def _root(share: Array) -> Array:
    """The cube root of CIE 1976, which is a straight line near 0."""
    return np.where(share > _DARK**3, np.cbrt(share), share / (3.0 * _DARK**2) + 4.0 / 29.0)


def _bin(value: Array) -> Array:
    bins: Array = np.clip(np.floor(value * BINS), 0, BINS - 1)
    return bins.astype(np.int32)
