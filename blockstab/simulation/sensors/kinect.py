"""Depth as a Kinect v1 measures it: structured light, one infrared camera, one projector beside it."""

from __future__ import annotations

import math
from dataclasses import dataclass

import torch
from torch import Tensor

from blockstab.rgbd.frame import Camera
from blockstab.simulation.sensors.echoes import swallowed
from blockstab.simulation.sensors.patches import patchy_noise

_CAMERA = Camera(fx=525.0, fy=525.0, cx=319.5, cy=239.5)  # OpenNI's default
_FOCAL_PX = 580.0  # of the infrared camera, in whose pixels disparity is measured
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


@dataclass(frozen=True)
class Kinect:
    """A Kinect v1 with depth registered to its colour camera; its second eye is the projector, on the right."""

    camera: Camera = _CAMERA
    height_px: int = 480
    width_px: int = 640
    baseline: float = 0.075
    slip_px: float = 1.2

    def measure(
        self, depth: Tensor, incidence: Tensor, lit: Tensor, echo: Tensor, generator: torch.Generator
    ) -> Tensor:
        """Turn true depth into what the sensor reports; arguments and result are those of `Sensor.measure`.

        Edges fray by a pixel, and here and there pixels up to a few from them are lost; noise grows with the
        square of the distance, and the fainter the echo; disparity comes in eighths of a pixel; depth is missing
        in the projector's shadow, on surfaces seen at over 80 degrees, in patches where little light comes back,
        and where true depth is out of range.
        """
        source, lost = _frayed(depth, incidence, generator)
        depth, incidence, lit, echo = (image.flatten()[source] for image in (depth, incidence, lit, echo))
        steep = incidence + _STEEP_JITTER * patchy_noise(depth.shape, _WINDOW, generator) > _STEEPEST
        faint = swallowed(echo, generator)
        seen = lit & ~lost & ~steep & ~faint & (depth > _NEAREST) & (depth < _FURTHEST)
        true = torch.where(seen, depth, 1.0)
        reach = self.baseline * _FOCAL_PX
        # The published noise contains that of rounding disparity, which is added below.
        noise = axial_noise(true, torch.where(seen, incidence, 0.0)) * reach / true**2 / echo
        unrounded = (noise**2 - _DISPARITY_STEP_PX**2 / 12).clamp(min=0.0).sqrt()
        disparity = reach / true + unrounded * patchy_noise(depth.shape, _WINDOW, generator)
        steps = (disparity / _DISPARITY_STEP_PX).round().clamp(min=1.0)
        measured = (1000.0 * reach / (steps * _DISPARITY_STEP_PX)).round() / 1000.0
        return torch.where(seen, measured, 0.0)


def _frayed(depth: Tensor, incidence: Tensor, generator: torch.Generator) -> tuple[Tensor, Tensor]:
    """Source pixel of each pixel's (H, W) depth, as an index into the flattened image; mask of those with none."""
    height, width = depth.shape
    rows, columns = torch.meshgrid(torch.arange(height), torch.arange(width), indexing="ij")
    down, right = (
        (_LATERAL_PX * patchy_noise(depth.shape, _WINDOW, generator)).round().long() for _ in range(2)
    )
    beside = (rows + down).clamp(0, height - 1) * width + (columns + right).clamp(0, width - 1)
    step = (depth.flatten()[beside] - depth).abs()
    # Where a window is off by more than a pixel, too little of it is left on either side of an edge to match;
    # across a steep surface it still does.
    off = torch.maximum(down.abs(), right.abs())
    slope = depth / _FOCAL_PX * incidence.clamp(max=_STEEPEST).tan()
    lost = (off > 1) & (step > _EDGE + 2 * off * slope)
    return torch.where(step > _EDGE, beside, rows * width + columns), lost
