"""Gaps in masks and label images: small ones are noise of the sensor, larger ones are things that it does not see."""

from __future__ import annotations

import numpy as np
import torch
from scipy.ndimage import maximum_filter, minimum_filter
from skimage.measure import label as components
from skimage.segmentation import clear_border, watershed
from torch import Tensor

REACH_PX = 3
"""A gap is small where no pixel of it is farther than this from what surrounds it."""


def without_gaps(mask: Tensor, reach_px: int = REACH_PX) -> Tensor:
    """The (H, W) bool mask with those gaps closed of which no pixel lies deeper than `reach_px`."""
    size = 2 * reach_px + 1
    grown = maximum_filter(mask.numpy().view(np.uint8), size, mode="constant", cval=0)
    shrunk = minimum_filter(grown, size, mode="constant", cval=1)
    return mask | torch.from_numpy(shrunk > 0)


def fill_gaps(label: Tensor, reach_px: int = REACH_PX) -> Tensor:
    """The (H, W) int64 label image with its small gaps closed, each pixel by the label fewest steps away.

    Labels grow through 4-connected pixels only, so a connected region stays connected.
    """
    closed = without_gaps(label > 0, reach_px)
    flooded = watershed(torch.zeros_like(label).numpy(), label.numpy(), mask=closed.numpy(), connectivity=1)
    return torch.from_numpy(flooded).to(torch.int64)


def enclosed(mask: Tensor) -> Tensor:
    """(H, W) bool, those 4-connected pieces of a mask that do not touch the rim of the image."""
    return torch.from_numpy(clear_border(components(mask.numpy(), connectivity=1)) > 0)


def flood_gaps(label: Tensor, gaps: Tensor, height: Tensor) -> Tensor:
    """The (H, W) int64 label image, its labels grown into `gaps` as water of rising `height` (H, W) would.

    Labels grow through 4-connected pixels only, so a connected region stays connected.
    """
    if not bool(gaps.any()):
        return label
    area = (label > 0) | gaps
    return torch.from_numpy(
        watershed(height.numpy(), label.numpy(), mask=area.numpy(), connectivity=1)
    ).long()
