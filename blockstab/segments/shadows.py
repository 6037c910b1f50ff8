"""Shadows of a depth sensor: gaps beside near things, that lie on what is behind these."""

from __future__ import annotations

import torch
from torch import Tensor

_MARGIN_PX = 3.0  # edges of depth fray
_JUMP_M = (0.01, 0.01)  # the least, and what is added per square metre of distance: three steps of a Kinect


def shadows(depth: Tensor, focal_px: float, baseline_m: float) -> Tensor:
    """For each pixel in a shadow, the column in its row of the surface that the shadow lies on.

    What only one of a sensor's two eyes sees has no depth. Beside a thing at depth `near`, in front of something at
    `far`, that is a strip along the row of `focal_px * baseline_m * (1 / near - 1 / far)` pixels, and what lies in
    it is the surface behind. A wider gap, or one between equal depths, is no shadow: there is something that the
    sensor does not see.

    Args:
        depth: (H, W) float64, metres, 0 = missing; the sensor's eyes lie side by side along the rows.
        baseline_m: between the eyes, at most.

    Returns:
        (H, W) int64; -1 where there is no shadow.
    """
    valid, width = depth > 0, depth.shape[1]
    left, right = _neighbours(valid)
    inside = ~valid & (left >= 0) & (right < width)
    left, right = left.clamp(min=0), right.clamp(max=width - 1)
    on_left, on_right = depth.gather(1, left), depth.gather(1, right)
    near, far = torch.minimum(on_left, on_right), torch.maximum(on_left, on_right)
    cast = focal_px * baseline_m * (1.0 / near - 1.0 / far) + _MARGIN_PX
    inside &= (far - near > _JUMP_M[0] + _JUMP_M[1] * near**2) & (right - left - 1 <= cast)
    return torch.where(inside, torch.where(on_left > on_right, left, right), -1)


def cast_on(label: Tensor, shadow: Tensor) -> Tensor:
    """A label image (H, W) in which every pixel in a shadow, as `shadows` gives them, has what the shadow lies on."""
    return torch.where(shadow >= 0, label.gather(1, shadow.clamp(min=0)), label)


def _neighbours(valid: Tensor) -> tuple[Tensor, Tensor]:
    """The columns (H, W) of the nearest valid pixels to the left, -1 = none, and to the right, W = none."""
    width = valid.shape[1]
    column = torch.arange(width).expand_as(valid)
    left = torch.where(valid, column, -1).cummax(dim=1).values
    right = torch.where(valid, column, width).flip(1).cummin(dim=1).values.flip(1)
    return left, right
