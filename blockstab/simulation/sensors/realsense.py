"""Depth as a RealSense D435 measures it: active stereo, two infrared cameras matched block by block."""

from __future__ import annotations

import math
from dataclasses import dataclass

import torch
from torch import Tensor
from torch.nn.functional import max_pool2d

from blockstab.rgbd.frame import Camera
from blockstab.simulation.sensors.echoes import swallowed
from blockstab.simulation.sensors.patches import patchy_noise

_CAMERA = Camera(fx=615.0, fy=615.0, cx=319.5, cy=239.5)  # its colour camera sees 42 degrees of height
_SUBPIXEL_PX = 0.08  # root mean square error of disparity; the makers say 0.03 at best, 0.08 to reckon with
_DISPARITY_STEP_PX = 1 / 32  # Grunnet-Jepsen et al., Subpixel Linearity Improvement for D400 (2019)
_NEAREST, _FURTHEST = 0.28, 6.0  # metres; the nearest is the data sheet's, at 1280 x 720
_STEEPEST = math.radians(80.0)  # no match on a surface seen more from the side
_STEEP_JITTER = math.radians(2.0)
# Not published: we take a matching window of 7 x 7, which spreads what is near by at most its half.
_WINDOW = (7, 7)
_SPREAD_PX = 3
_EDGE_PX = 0.25  # a jump of disparity that counts as an edge
# Along edges, fate is normal noise of unit variance: below the first no match, above the second a mixture.
_LOST, _MIXED = -0.5, 1.0
_FATE_WINDOW = (3, 3)


@dataclass(frozen=True)
class RealSense:
    """A D435 with depth aligned to its colour camera, which stands for the left infrared camera.

    Noise is even in disparity, so that depth errs by `z ** 2 * subpixel / (focal length * baseline)`
    (Grunnet-Jepsen, Sweetser and Woodfill, Best-Known-Methods for Tuning Intel RealSense D400 Depth Cameras
    for Best Performance): 2.6 mm at 1 m, 10 mm at 2 m. Matching windows overlap, so surfaces are wavy rather
    than grainy.

    The second eye is on the right. From there a near object stands further left before its background, and
    hides what is beside its left edge: that is where the shadow falls.
    """

    camera: Camera = _CAMERA
    height_px: int = 480
    width_px: int = 640
    baseline: float = 0.05
    slip_px: float = 0.8

    def measure(
        self, depth: Tensor, incidence: Tensor, lit: Tensor, echo: Tensor, generator: torch.Generator
    ) -> Tensor:
        """Turn true depth into what the sensor reports; arguments and result are those of `Sensor.measure`.

        What is near spreads over what is behind it by up to three pixels. Along edges a third of the pixels
        has no depth, and some fly: theirs lies in between, up to one pixel further. Disparity comes in steps
        of 1/32 pixel, and errs the more the fainter the echo. Depth is missing in the second eye's shadow, on
        surfaces seen at over 80 degrees, in patches where little light comes back, and nearer than 0.28 m or
        further than 6 m.
        """
        reach = self.baseline * self.camera.fx
        disparity = torch.where(depth > 0, reach / depth, 0.0)
        # What disparity changes by from a pixel to the next on a plane in the middle of the picture.
        slope = disparity / self.camera.fx * incidence.clamp(max=_STEEPEST).tan()
        source = _spread(disparity, slope, generator)
        disparity, slope, incidence, lit, echo = (
            image.flatten()[source] for image in (disparity, slope, incidence, lit, echo)
        )
        disparity = _torn(disparity, slope, generator)
        steep = incidence + _STEEP_JITTER * patchy_noise(depth.shape, _WINDOW, generator) > _STEEPEST
        # The published noise contains that of rounding disparity, which is added below.
        unrounded = math.sqrt(_SUBPIXEL_PX**2 - _DISPARITY_STEP_PX**2 / 12)
        faint = swallowed(echo, generator)
        noisy = disparity + unrounded / echo * patchy_noise(depth.shape, _WINDOW, generator)
        steps = (noisy / _DISPARITY_STEP_PX).round().clamp(min=1.0)
        measured = (1000.0 * reach / (steps * _DISPARITY_STEP_PX)).round() / 1000.0
        in_range = (measured >= _NEAREST) & (measured <= _FURTHEST)
        return torch.where(lit & ~steep & ~faint & (disparity > 0) & in_range, measured, 0.0)


def _spread(disparity: Tensor, slope: Tensor, generator: torch.Generator) -> Tensor:
    """Source pixel of each pixel's (H, W) disparity, as an index into the flattened image.

    Args:
        disparity: (H, W) pixels, 0 where there is nothing.
        slope: (H, W) pixels of disparity from a pixel to the next that are no edge.
    """
    spread = (_SPREAD_PX / 2 + patchy_noise(disparity.shape, _WINDOW, generator)).round()
    own = torch.arange(disparity.numel()).view(disparity.shape)
    source, nearest, at = own, disparity, own
    for distance in range(1, _SPREAD_PX + 1):
        nearest, beside = _largest_beside(nearest)
        at = at.flatten()[beside]
        steepest = torch.maximum(slope, slope.flatten()[at])
        jump = nearest - disparity > _EDGE_PX + distance * steepest
        source = torch.where(jump & (spread >= distance), at, source)
    return source


def _torn(disparity: Tensor, slope: Tensor, generator: torch.Generator) -> Tensor:
    """Disparity (H, W) with pixels along edges lost, which makes them 0, or mixed from both sides."""
    near, far = _largest_beside(disparity)[0], -_largest_beside(-disparity)[0]
    share = torch.rand(disparity.shape, generator=generator, dtype=torch.float64)
    fate = patchy_noise(disparity.shape, _FATE_WINDOW, generator)
    edge = near - far > _EDGE_PX + 2 * slope
    torn = torch.where(edge & (fate > _MIXED) & (far > 0), far + share * (near - far), disparity)
    return torch.where(edge & (fate < _LOST), 0.0, torn)


def _largest_beside(image: Tensor) -> tuple[Tensor, Tensor]:
    """The largest value (H, W) among each pixel and its eight neighbours, and where it is, as a flat index."""
    largest, at = max_pool2d(image[None], kernel_size=3, stride=1, padding=1, return_indices=True)
    return largest[0], at[0]
