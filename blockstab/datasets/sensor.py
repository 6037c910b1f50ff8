"""Depth as a Kinect v1 measures it: structured light, one infrared camera, one projector beside it."""

from __future__ import annotations

import math

import torch
from torch import Tensor
from torch.nn.functional import avg_pool2d

BASELINE = 0.075  # metres from the infrared camera to the projector, along +x of the camera
_FOCAL_PX = 580.0
_DISPARITY_STEP_PX = 1 / 8  # Khoshelham and Elberink 2012
_NEAREST, _FURTHEST = 0.45, 5.0  # metres
_STEEPEST = math.radians(80.0)  # no echo comes back from a surface seen more from the side
_STEEP_JITTER = math.radians(1.5)
_LATERAL_PX = 0.8  # Nguyen et al. 2012: standard deviation across the line of sight
_EDGE = 0.02  # metres; a jump between neighbours that counts as an edge
# Neighbouring pixels share most of the window that the sensor correlates, so that errors of pixels 1 and 3
# apart agree by 0.7 and 0.4 along a row, and by 0.5 and 0.1 along a column (measured on flat tables).
_WINDOW = (3, 5)


def axial_noise(depth: Tensor, incidence: Tensor) -> Tensor:
    """Standard deviation of measured depth, metres (Nguyen et al. 2012, Eq. 3).

    Args:
        depth: metres, positive.
        incidence: radians between the line of sight and the surface normal, less than pi / 2.
    """
    flat = 0.0012 + 0.0019 * (depth - 0.4) ** 2
    steep = 0.0001 / depth.sqrt() * (incidence / (math.pi / 2 - incidence)) ** 2
    return flat + torch.where(incidence > math.pi / 3, steep, 0.0)


def measure(depth: Tensor, incidence: Tensor, lit: Tensor, generator: torch.Generator) -> Tensor:
    """Turn true depth into what the sensor reports.

    Edges fray by about a pixel; noise grows with the square of the distance; disparity comes in eighths of a
    pixel; depth is missing in the projector's shadow, on surfaces seen at over 80 degrees, and out of range.

    Args:
        depth: (H, W) float64 true depth, metres; 0 where there is nothing.
        incidence: (H, W) radians between the line of sight and the surface normal.
        lit: (H, W) bool, whether the projector reaches the surface.

    Returns:
        (H, W) float64, metres in whole millimetres; 0 where the sensor gives none.
    """
    source = _frayed(depth, generator)
    depth, incidence, lit = (image.flatten()[source] for image in (depth, incidence, lit))
    steep = incidence + _STEEP_JITTER * _patchy_noise(depth.shape, generator) > _STEEPEST
    seen = lit & ~steep & (depth > _NEAREST) & (depth < _FURTHEST)
    true = torch.where(seen, depth, 1.0)
    reach = BASELINE * _FOCAL_PX
    # The published noise contains that of rounding disparity, which is added below.
    noise = axial_noise(true, torch.where(seen, incidence, 0.0)) * reach / true**2
    unrounded = (noise**2 - _DISPARITY_STEP_PX**2 / 12).clamp(min=0.0).sqrt()
    disparity = reach / true + unrounded * _patchy_noise(depth.shape, generator)
    steps = (disparity / _DISPARITY_STEP_PX).round().clamp(min=1.0)
    measured = (1000.0 * reach / (steps * _DISPARITY_STEP_PX)).round() / 1000.0
    return torch.where(seen, measured, 0.0)


def _frayed(depth: Tensor, generator: torch.Generator) -> Tensor:
    """Which pixel each pixel (H, W) gets its depth from, as an index into the flattened image."""
    height, width = depth.shape
    rows, columns = torch.meshgrid(torch.arange(height), torch.arange(width), indexing="ij")
    down, right = (_LATERAL_PX * _patchy_noise(depth.shape, generator) for _ in range(2))
    beside = (rows + down.round().long()).clamp(0, height - 1) * width
    beside += (columns + right.round().long()).clamp(0, width - 1)
    jump = (depth.flatten()[beside] - depth).abs() > _EDGE
    return torch.where(jump, beside, rows * width + columns)


def _patchy_noise(shape: torch.Size, generator: torch.Generator) -> Tensor:
    """Normal noise (H, W) of unit variance that neighbouring pixels share."""
    height, width = _WINDOW
    white = torch.randn(
        1, shape[0] + height - 1, shape[1] + width - 1, generator=generator, dtype=torch.float64
    )
    return avg_pool2d(white, _WINDOW, stride=1)[0] * math.sqrt(height * width)
