"""Pictures of an image's segments and depth, as RGB arrays."""

from __future__ import annotations

import torch
from torch import Tensor
from torch.nn.functional import max_pool2d

# Anchors from near to far (viridis, reversed): lightness falls evenly, so that the ramp also reads in grey.
DEPTH_RAMP = ((253, 231, 37), (122, 209, 81), (34, 168, 132), (42, 120, 142), (65, 68, 135), (68, 1, 84))


def outlined(color: Tensor, label: Tensor, palette: Tensor, width_px: int = 3) -> Tensor:
    """Draw the outline of every segment over the image, just inside its border.

    Args:
        color: (H, W, 3) uint8.
        label: (H, W) int64; 0 is left alone.
        palette: (L, 3) uint8, the colour of each label's outline; L exceeds the largest label.
        width_px: of each outline.

    Returns:
        (H, W, 3) uint8.
    """
    # Float64 holds every label exactly, and pooling wants floats. Outside the image there is no other label.
    plane = label.double()[None, None]
    window = 2 * width_px + 1
    highest = max_pool2d(plane, window, stride=1, padding=width_px)[0, 0]
    lowest = -max_pool2d(-plane, window, stride=1, padding=width_px)[0, 0]
    border = (highest != lowest) & (label > 0)
    return torch.where(border[..., None], palette[label], color)


def depth_range(depth: Tensor) -> tuple[float, float]:
    """Near and far, metres, of all measured depths but the outermost per cent at each end (0 = missing).

    An image without any depth has the range 0 to 1.
    """
    measured = depth[depth > 0]
    if not len(measured):
        return 0.0, 1.0
    ordered = measured.sort().values
    last = len(ordered) - 1
    return float(ordered[round(0.01 * last)]), float(ordered[round(0.99 * last)])


def depth_colored(depth: Tensor, near: float, far: float) -> Tensor:
    """Colour each depth by its place between `near` and `far`, metres; missing depth is black.

    Returns:
        (H, W, 3) uint8.
    """
    ramp = torch.tensor(DEPTH_RAMP, dtype=torch.float64, device=depth.device)
    place = ((depth - near) / max(far - near, 1e-6)).clamp(0, 1) * (len(ramp) - 1)
    below = place.long().clamp(max=len(ramp) - 2)
    part = (place - below)[..., None]
    mixed = (1 - part) * ramp[below] + part * ramp[below + 1]
    return (mixed.round() * (depth > 0)[..., None]).to(torch.uint8)
