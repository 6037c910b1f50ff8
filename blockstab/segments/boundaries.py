"""How likely each pixel is to lie on an edge between two objects."""

from __future__ import annotations

import torch
import torch.nn.functional as F
from kornia.color import rgb_to_lab
from kornia.filters import gaussian_blur2d, spatial_gradient
from torch import Tensor

from blockstab.rgbd.cloud import SENSOR_STEP, Cloud
from blockstab.rgbd.frame import Frame
from blockstab.segments.gaps import without_gaps

_COLOR_SHARE = 0.3  # printed boxes carry strong colour edges: alone, they must not outweigh geometry
_COLOR_FULL = 12.0  # Lab units per pixel that make a full colour edge
_JUMP = (2.0, 6.0)  # explained steps: no edge below the first, a full edge above the second
_BEND = (0.1, 0.6)  # twice the sine of half the angle of a crease, likewise
_JUMP_REACH_PX, _BEND_REACH_PX = 2, 4
_DIRECTIONS = ((0, 1), (1, 0), (1, 1), (1, -1))  # rows, columns


def boundary_strength(frame: Frame, cloud: Cloud) -> Tensor:
    """The strongest of four signs of an edge at each pixel, (H, W) float64 between 0 and 1.

    * Depth jumps: the surface on either side does not reach the other side.
    * Concave creases, where one thing stands on or leans against another. Convex creases do not count: the
      faces of one box meet in them (Gupta et al. 2013; Stein et al. 2014, "Object partitioning using local
      convexity").
    * The rim of large areas without depth, most of them the shadow beside an object.
    * Colour edges, at a small share: they order what lies inside one object.

    Args:
        frame: the image.
        cloud: its points and normals, in the camera frame or the world frame.
    """
    focal_px = frame.camera.fx
    # Outside the image nothing is measured.
    surface = F.pad(_smoothed_surface(cloud), (_BEND_REACH_PX,) * 4)
    jumps = creases = torch.zeros_like(cloud.depth, dtype=torch.float32)
    for direction in _DIRECTIONS:
        near = _sides(surface, direction, _JUMP_REACH_PX)
        far = _sides(surface, direction, _BEND_REACH_PX)
        # Narrow shadows are edges too, but only the far pair sees across them. It explains twice the step.
        jump = torch.where(cloud.valid, _jump(*near, focal_px), 0.5 * _jump(*far, focal_px))
        jumps = torch.maximum(jumps, _ramp(jump, *_JUMP))
        creases = torch.maximum(creases, _ramp(_concave_bend(*far, focal_px), *_BEND))
    strength = torch.maximum(jumps, _thinned(creases))
    strength = torch.maximum(strength, _COLOR_SHARE * _color_edges(frame.color))
    return torch.maximum(strength, _rim(without_gaps(cloud.valid))).double()


def _color_edges(color: Tensor) -> Tensor:
    """(H, W) float32 length of the Lab gradient, 0 to 1."""
    lab = rgb_to_lab(color.permute(2, 0, 1)[None].float() / 255.0)
    gradient = spatial_gradient(gaussian_blur2d(lab, (9, 9), (1.5, 1.5)), mode="diff")[0].flatten(0, 1)
    return (_dot(gradient, gradient).sqrt() / _COLOR_FULL).clamp(max=1.0)


def _smoothed_surface(cloud: Cloud) -> Tensor:
    """(8, H, W) float32: point, unit normal, depth, all means over 3 x 3 pixels; and whether measured."""
    mask = cloud.valid[None].float()
    values = torch.cat(
        [cloud.points.permute(2, 0, 1), cloud.normals.permute(2, 0, 1), cloud.depth[None]]
    ).float()
    share = F.avg_pool2d(mask, 3, stride=1, padding=1)
    mean = F.avg_pool2d(values, 3, stride=1, padding=1) / share.clamp(min=1e-6) * mask
    normals = mean[3:6] / _dot(mean[3:6], mean[3:6]).sqrt().clamp(min=1e-6)
    return torch.cat([mean[:3], normals, mean[6:], mask])


def _sides(padded: Tensor, direction: tuple[int, int], reach_px: int) -> tuple[Tensor, Tensor]:
    """The surface `reach_px` before and behind every pixel, (8, H, W) each."""
    rows, columns = direction
    step = reach_px if rows * columns == 0 else round(reach_px / 2**0.5)
    height, width = (size - 2 * _BEND_REACH_PX for size in padded.shape[1:])

    def shifted(sign: int) -> Tensor:
        top, left = _BEND_REACH_PX + sign * rows * step, _BEND_REACH_PX + sign * columns * step
        return padded[:, top : top + height, left : left + width]

    return shifted(-1), shifted(1)


def _explained_step(a: Tensor, b: Tensor, focal_px: float) -> Tensor:
    """(H, W) metres: what the sensor's resolution, or a crease between two pixels, can explain."""
    depth = torch.minimum(a[6], b[6])
    return torch.maximum(SENSOR_STEP * depth**2, depth / focal_px).clamp(min=1e-6)


def _jump(a: Tensor, b: Tensor, focal_px: float) -> Tensor:
    """(H, W) distance of either side to the plane of the other, the nearer one, in explained steps."""
    offset = b[:3] - a[:3]
    gap = (b[6] - a[6]).abs()
    for side in (a, b):
        known = _dot(side[3:6], side[3:6]) > 0
        gap = torch.where(known, torch.minimum(gap, _dot(side[3:6], offset).abs()), gap)
    return gap / _explained_step(a, b, focal_px) * (a[7] * b[7])


def _concave_bend(a: Tensor, b: Tensor, focal_px: float) -> Tensor:
    """(H, W) how far the normals turn towards each other: above 0 at concave creases, below at convex ones.

    Zero where a normal is unknown, and where the two sides lie so far apart that they are no one surface.
    """
    offset = b[:3] - a[:3]
    length = _dot(offset, offset).sqrt()
    known = (_dot(a[3:6], a[3:6]) > 0) & (_dot(b[3:6], b[3:6]) > 0)
    linked = length < 8 * _BEND_REACH_PX * _explained_step(a, b, focal_px)
    bend = -_dot(b[3:6] - a[3:6], offset) / length.clamp(min=1e-6)
    return torch.where(known & linked, bend, 0.0)


def _ramp(value: Tensor, low: float, high: float) -> Tensor:
    return ((value - low) / (high - low)).clamp(0.0, 1.0)


def _thinned(creases: Tensor) -> Tensor:
    """Creases are seen from `_BEND_REACH_PX` on either side; keep the middle half of what they cover."""
    for _ in range(_BEND_REACH_PX // 2):
        rows = F.max_pool2d(-creases[None], (3, 1), stride=1, padding=(1, 0))
        columns = F.max_pool2d(-creases[None], (1, 3), stride=1, padding=(0, 1))
        creases = -torch.maximum(rows, columns)[0]
    return creases


def _rim(mask: Tensor) -> Tensor:
    """(H, W) float32, 1 outside the mask and on the pixels of it that touch the outside."""
    return F.max_pool2d(1.0 - mask.float()[None], 3, stride=1, padding=1)[0]


def _dot(a: Tensor, b: Tensor) -> Tensor:
    """Sum over the first dimension of a * b; ten times as fast as a reduction across planes."""
    total = a[0] * b[0]
    for k in range(1, len(a)):
        total = torch.addcmul(total, a[k], b[k])
    return total
