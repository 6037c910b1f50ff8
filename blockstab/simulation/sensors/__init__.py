"""Depth sensors that a scene can be seen by. A sensor is anything of the shape `Sensor`."""

from __future__ import annotations

from typing import Protocol

import torch
from torch import Tensor

from blockstab.rgbd.frame import Camera
from blockstab.simulation.naming import named
from blockstab.simulation.sensors.ideal import Ideal
from blockstab.simulation.sensors.kinect import Kinect
from blockstab.simulation.sensors.realsense import RealSense


class Sensor(Protocol):
    """A depth sensor whose image is pixel upon pixel with the colour image."""

    @property
    def camera(self) -> Camera:
        """Intrinsics of the colour and the depth image.

        Its noise is what a parse reckons with. Ours all leave it at a Kinect's: potentials that were trained on
        RealSense scenes with their own, coarser noise were no better on the scenes kept for such choices.
        """

    @property
    def height_px(self) -> int: ...

    @property
    def width_px(self) -> int: ...

    @property
    def baseline(self) -> float:
        """Metres along +x of the camera to its second eye, or projector; 0 where it has none.

        What the second eye does not see is in its shadow, and has no depth.
        """

    @property
    def slip_px(self) -> float:
        """Standard deviation of what the colour image is off against depth along rows and columns, pixels."""

    def measure(
        self, depth: Tensor, incidence: Tensor, lit: Tensor, echo: Tensor, generator: torch.Generator
    ) -> Tensor:
        """Turn true depth into what the sensor reports.

        Args:
            depth: (H, W) float64 true depth, metres; 0 where there is nothing.
            incidence: (H, W) radians between the line of sight and the surface normal, 0 to pi / 2.
            lit: (H, W) bool, whether the second eye sees the surface.
            echo: (H, W) share of infrared light that comes back from the surface, above 0 to 1.

        Returns:
            (H, W) float64, metres in whole millimetres; 0 where the sensor gives none.
        """


SENSORS: dict[str, Sensor] = {"kinect": Kinect(), "realsense": RealSense(), "ideal": Ideal()}


def sensor(name: str) -> Sensor:
    """The sensor of that name, or of a class of one's own that is named as `package.module.Class`.

    Raises:
        ValueError: there is none.
    """
    return named("sensor", name, SENSORS)
