"""Cues of an edge that an image's colours give: brightness, colour and texture (Martin, Fowlkes and Malik 2004)."""

from __future__ import annotations

import numpy as np
import torch
import torch.nn.functional as F
from torch import Tensor

from blockstab.boundaries.colors import blurred, brightness_bins, color_bins, halved
from blockstab.boundaries.histograms import chi_squared_gradient, quadratic_gradient
from blockstab.boundaries.smoothing import smoothed
from blockstab.boundaries.textons import textons

COLOR_GRADIENTS = ("brightness", "color_a", "color_b", "texture")

_RADIUS_PX = 4  # of brightness, in the image; of the others, in an image of half its width and height
_BIAS, _WEIGHTS = -4.50, (1.69, 0.96, 1.00, 2.81)
# Five standard deviations over all pixels and orientations of 16 simulated scenes ("objects", seed 9100). Most of
# such a scene is plain, so with one the sum would saturate along every edge; with five the result is nearest to the
# share of pixels that lie within two of a boundary (Brier score).
_SCALES = (0.296, 0.108, 0.110, 1.07)


def color_gradients(color: Tensor) -> Tensor:
    """Differences of the two sides of each pixel in brightness, in the colours a and b of Lab, and in texture.

    Sides are half discs, of radius 4 pixels for brightness and 8 for the others. Their histograms are compared, and
    the distances smoothed along the orientation. What has radius 8 is computed on means of 2 x 2 pixels, which hide
    little after the blur, and interpolated. Beyond its rim the image is mirrored.

    Args:
        color: (H, W, 3) uint8.

    Returns:
        (4, 4, H, W) float32, 0 to 1: gradients in the order of `COLOR_GRADIENTS`, each at the four orientations of
        `BoundaryMap`. 0 for equal sides, 1 for sides that have nothing alike, such as black and white; but the blur
        lowers a sharp step from black to white to 0.7 in brightness.
    """
    height, width = color.shape[:2]
    rgb = blurred(color.numpy())
    brightness = smoothed(quadratic_gradient(brightness_bins(rgb), _RADIUS_PX), _RADIUS_PX)
    a, b = (quadratic_gradient(bins, _RADIUS_PX) for bins in color_bins(halved(rgb)))
    texture = chi_squared_gradient(textons(rgb), _RADIUS_PX)
    coarse = torch.from_numpy(smoothed(np.stack([a, b, texture]), _RADIUS_PX))
    fine = F.interpolate(coarse, scale_factor=2, mode="bilinear")[..., :height, :width]
    return torch.cat([torch.from_numpy(brightness)[None], fine])


def pb(gradients: Tensor) -> Tensor:
    """The probability of a boundary at each orientation, (4, H, W) float32, from (4, 4, H, W) gradients.

    It is the logistic combination that Martin, Fowlkes and Malik (2004) fitted to edges that people drew. Its weights
    are per unit of each gradient; their units are not known, and those used here are measured on simulated scenes.
    """
    logit = torch.full_like(gradients[0], _BIAS)
    for gradient, weight, scale in zip(gradients, _WEIGHTS, _SCALES, strict=True):
        logit.add_(gradient * (weight / scale))
    # Unlike `sigmoid`, this rounds every pixel in the same way, whichever thread it falls to.
    return logit.neg_().exp_().add_(1.0).reciprocal_()
