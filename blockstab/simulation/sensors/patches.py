"""Noise that neighbouring pixels share, as the windows they are matched by overlap."""

from __future__ import annotations

import math

import torch
from torch import Tensor
from torch.nn.functional import avg_pool2d


def patchy_noise(shape: torch.Size, window: tuple[int, int], generator: torch.Generator) -> Tensor:
    """Normal noise (H, W) of unit variance, alike at pixels whose windows overlap.

    Args:
        shape: (H, W).
        window: height and width, pixels. Between pixels u rows and v columns apart the correlation is
            (1 - u / height) (1 - v / width), and none from a whole window on.
    """
    height, width = window
    white = torch.randn(
        1, shape[0] + height - 1, shape[1] + width - 1, generator=generator, dtype=torch.float64
    )
    return avg_pool2d(white, window, stride=1)[0] * math.sqrt(height * width)
