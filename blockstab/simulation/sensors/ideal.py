"""Depth without error, but for the millimetres it is stored in."""

from __future__ import annotations

from dataclasses import dataclass

import torch
from torch import Tensor

from blockstab.rgbd.frame import Camera

_CAMERA = Camera(fx=525.0, fy=525.0, cx=319.5, cy=239.5)
_FURTHEST = 65.535  # metres; the last millimetre that an image of 16 bits holds


@dataclass(frozen=True)
class Ideal:
    """A sensor with one eye, from which nothing that is in the picture hides."""

    camera: Camera = _CAMERA
    height_px: int = 480
    width_px: int = 640
    baseline: float = 0.0
    slip_px: float = 0.0

    def measure(
        self, depth: Tensor, incidence: Tensor, lit: Tensor, echo: Tensor, generator: torch.Generator
    ) -> Tensor:
        """Round true depth to whole millimetres; arguments and result are those of `Sensor.measure`."""
        rounded = (1000.0 * depth).round() / 1000.0
        return torch.where(rounded <= _FURTHEST, rounded, 0.0)
