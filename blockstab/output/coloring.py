"""Pictures of an image's segments, their quality, and depth, as RGB arrays."""

from __future__ import annotations

import torch
from torch import Tensor
from torch.nn.functional import max_pool2d

# Anchors from near to far (viridis, reversed): lightness falls evenly, so that the ramp also reads in grey.
DEPTH_RAMP = ((253, 231, 37), (122, 209, 81), (34, 168, 132), (42, 120, 142), (65, 68, 135), (68, 1, 84))
# From good to bad, as in the paper's Figure 11: "the better quality the segments are, the more blue".
QUALITY_RAMP = ((38, 70, 200), (40, 160, 220), (245, 215, 60), (235, 130, 40), (200, 30, 30))

# Of things side by side in a world of boxes.
WORLD_COLORS = ((31, 119, 180), (23, 163, 152), (106, 90, 205), (77, 159, 58), (0, 166, 214), (148, 103, 189))


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
    place = (depth - near) / max(far - near, 1e-6)
    return _ramped(place, DEPTH_RAMP) * (depth > 0)[..., None]


def quality_colored(potential: Tensor) -> Tensor:
    """A colour for each potential: blue for 0, good, red for 1, bad; as for the nearer of them beyond.

    Returns:
        (N, 3) uint8.
    """
    return _ramped(potential, QUALITY_RAMP)


def tinted(color: Tensor, label: Tensor, palette: Tensor, share: float = 0.5) -> Tensor:
    """Lay a colour over every segment.

    Args:
        color: (H, W, 3) uint8.
        label: (H, W) int64; 0 is left alone.
        palette: (L, 3) uint8, the colour of each label; L exceeds the largest label.
        share: of that colour.

    Returns:
        (H, W, 3) uint8.
    """
    mixed = (1 - share) * color.double() + share * palette[label].double()
    return torch.where((label > 0)[..., None], mixed.round().to(torch.uint8), color)


def borders_colored(color: Tensor, label: Tensor, palette: Tensor, width_px: int = 2) -> Tensor:
    """Draw the border of every two segments over the image.

    Args:
        color: (H, W, 3) uint8.
        label: (H, W) int64; nothing borders on 0.
        palette: (L, L, 3) uint8, symmetric, the colour between each two labels; black is not drawn.
        width_px: to either side.

    Returns:
        (H, W, 3) uint8.
    """
    count = len(palette)
    pair = torch.zeros_like(label)
    for one, other, place in (
        (label[:, :-1], label[:, 1:], pair[:, :-1]),
        (label[:-1], label[1:], pair[:-1]),
    ):
        between = (one != other) & (one > 0) & (other > 0) & (palette[one, other] > 0).any(dim=-1)
        place[between] = (one * count + other)[between]
    window = 2 * width_px + 1
    wide = max_pool2d(pair.double()[None, None], window, stride=1, padding=width_px)[0, 0].long()
    return torch.where((wide > 0)[..., None], palette.flatten(0, 1)[wide], color)


def _ramped(place: Tensor, colors: tuple[tuple[int, int, int], ...]) -> Tensor:
    """(..., 3) uint8 colours of places on a ramp, 0 to 1."""
    ramp = torch.tensor(colors, dtype=torch.float64, device=place.device)
    place = place.clamp(0, 1) * (len(ramp) - 1)
    below = place.long().clamp(max=len(ramp) - 2)
    part = (place - below)[..., None]
    return ((1 - part) * ramp[below] + part * ramp[below + 1]).round().to(torch.uint8)
