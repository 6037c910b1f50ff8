"""Plain things for a sensor to look at."""

from __future__ import annotations

import math

import torch

from blockstab.simulation.sensors import Sensor

SHAPE = (240, 320)


def wall(distance: float) -> torch.Tensor:
    """A wall turned just enough that its depth crosses many steps of disparity."""
    across = torch.linspace(-0.03, 0.03, SHAPE[1], dtype=torch.float64)
    return (distance + distance**2 * across).expand(SHAPE).contiguous()


def panel(near: float, far: float) -> torch.Tensor:
    """A wall at `far`, and before its rows 80 to 159 and columns 100 to 219 a panel at `near`."""
    depth = torch.full(SHAPE, far, dtype=torch.float64)
    depth[80:160, 100:220] = near
    return depth


def seen(
    sensor: Sensor, depth: torch.Tensor, generator: torch.Generator, tilt_deg: float = 0.0, echo: float = 1.0
) -> torch.Tensor:
    """What the sensor reports where nothing is in shadow."""
    lit = torch.ones_like(depth, dtype=torch.bool)
    tilt = torch.full_like(depth, math.radians(tilt_deg))
    return sensor.measure(depth, tilt, lit, torch.full_like(depth, echo), generator)
