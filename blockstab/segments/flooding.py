"""Basins of the boundary strength, which water would fill from below."""

from __future__ import annotations

import numpy as np
import torch
import torch.nn.functional as F
from kornia.filters import gaussian_blur2d
from numpy.typing import NDArray
from scipy.ndimage import median_filter
from skimage.measure import label as components
from skimage.morphology import local_minima
from skimage.segmentation import watershed
from torch import Tensor

MOST_BASINS = 4000

_MEDIANS_PX = range(1, 16, 2)  # sides of windows, tried in order
_LEVEL = 0.02  # minima of the strength that differ by less are one
_BLUR_PX = 1.0  # standard deviation


def basins(strength: Tensor, area: Tensor) -> Tensor:
    """Flood a mask from the regional minima of the slightly blurred strength, 4-connected as they are.

    Of a picture so grainy that there are more than `MOST_BASINS`, the strength is smoothed first, by the smallest
    median filter that will do, up to 15 x 15 (Silberman et al. 2012).

    Args:
        strength: (H, W) float64, 0 to 1.
        area: (H, W) bool.

    Returns:
        (H, W) int64, the basins from 1; 0 outside the mask. They cover it.
    """
    for size in _MEDIANS_PX:
        smooth = torch.from_numpy(median_filter(strength.numpy(), size)) if size > 1 else strength
        markers = _minima(smooth, area)
        if markers.max() <= MOST_BASINS:
            break
    flooded = watershed(smooth.numpy(), markers, mask=area.numpy(), connectivity=1)
    return torch.from_numpy(flooded).to(torch.int64)


def _minima(strength: Tensor, area: Tensor) -> NDArray[np.int_]:
    """(H, W): the regional minima within a mask, numbered from 1; 0 elsewhere."""
    size = 2 * round(3 * _BLUR_PX) + 1
    blurred = gaussian_blur2d(strength[None, None], (size, size), (_BLUR_PX, _BLUR_PX))[0, 0]
    level = torch.where(area, blurred / _LEVEL, torch.inf).floor()
    # The frame of high values makes a picture without any edge one minimum, instead of none.
    minima = local_minima(F.pad(level, (1, 1, 1, 1), value=torch.inf).numpy(), connectivity=1)[1:-1, 1:-1]
    return np.asarray(components(minima & area.numpy(), connectivity=1))
