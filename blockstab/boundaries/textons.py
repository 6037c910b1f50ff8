"""Textons: which of a few elementary patterns an image shows at each place."""

from __future__ import annotations

from functools import cache

import numpy as np
import torch
import torch.nn.functional as F
from scipy.special import dawsn
from torch import Tensor

from blockstab.boundaries.half_discs import Array, mirrored

_ORIENTATIONS = 6
_SIGMAS_PX = (1.0, 2.0**0.5)  # across
_ELONGATION = 2.0
_GREY = (0.299, 0.587, 0.114)
_TAPS = 16  # pixels on a side of the filters, whose centre is the corner of four pixels
_RIM = 7  # textons at the rim of an image, where a filter would see what the blur has taken from beyond it
_FLAT = 0.004  # of the way from black to white: weaker answers are noise
_STEPS = 2.0**20  # per unit, to which answers are rounded

FLAT = 0  # the texton of places without any pattern


def textons(rgb: Array) -> Array:
    """Name the texton at the centre of every 2 x 2 pixels.

    It is the filter that answers most strongly: a bar or a step, at one of six orientations, whichever of two scales
    it has; and the sign of the answer. Where none answers, the place is `FLAT`. The outermost 14 pixels mirror the
    textons farther in, for filters of a blurred image would see patterns there which the image does not have. So an
    image of at most 28 rows or columns is flat.

    Textons in the usual sense are clusters of the answers of all filters, learned from images (Malik et al. 2001).
    These need no images, turn as the image turns, and do not change with the light (compare the basic image features
    of Crosier and Griffin 2010). On simulated scenes their gradient finds boundaries better than that of clusters of
    the image's own answers, which divide the noise of plain surfaces, and nearly as well as that of learned ones.

    Args:
        rgb: (3, H, W) float32, 0 to 1.

    Returns:
        (ceil(H / 2), ceil(W / 2)) int64, 0 to 24.
    """
    height, width = rgb.shape[1:]
    if min(height, width) <= 4 * _RIM:
        return np.full(((height + 1) // 2, (width + 1) // 2), FLAT)
    red, green, blue = _GREY
    grey: Array = red * rgb[0] + green * rgb[1] + blue * rgb[2]
    bank = filter_bank()
    first = 2 * _RIM + 1 - _TAPS // 2
    seen = grey[first : height - first + height % 2, first : width - first + width % 2]
    answers = F.conv2d(torch.from_numpy(seen)[None, None], bank.flatten(0, 2)[:, None], stride=2)[0]
    # Rounded, equal answers tie and the first one wins, in whichever order products were added.
    answers = answers.mul_(_STEPS).round_().view(len(bank), -1, *answers.shape[1:])
    strength, texton = torch.cat([answers.amax(dim=0), -answers.amin(dim=0)]).max(dim=0)
    return mirrored(torch.where(strength > _FLAT * _STEPS, texton + 1, FLAT).numpy(), _RIM)


@cache
def filter_bank() -> Tensor:
    """(2, 6, 2, 16, 16) float32: filters of two scales, six orientations, and even or odd symmetry.

    Even ones are second derivatives, across their orientation, of Gaussians twice as long as wide; odd ones are the
    Hilbert transforms of those (Malik et al. 2001). Values sum to 0, magnitudes to 1.
    """
    offset = np.arange(_TAPS) - (_TAPS - 1) / 2
    down, right = np.meshgrid(offset, offset, indexing="ij")
    angle = (np.arange(_ORIENTATIONS) * np.pi / _ORIENTATIONS)[:, None, None]
    along, across = right * np.cos(angle) - down * np.sin(angle), right * np.sin(angle) + down * np.cos(angle)
    sigma = np.array(_SIGMAS_PX)[:, None, None, None]
    x = across / (sigma * 2.0**0.5)
    # Of exp(-x^2) the Hilbert transform is Dawson's integral D times 2 / sqrt(pi); these are the second derivatives.
    even = (2.0 * x**2 - 1.0) * np.exp(-(x**2))
    odd = ((2.0 * x**2 - 1.0) * dawsn(x) - x) * 2.0 / np.pi**0.5
    bank = np.stack([even, odd], axis=2) * np.exp(-0.5 * (along / (_ELONGATION * sigma)) ** 2)[:, :, None]
    bank -= bank.mean(axis=(-2, -1), keepdims=True)
    return torch.from_numpy(bank / np.abs(bank).sum(axis=(-2, -1), keepdims=True)).float()
