"""Cues of an edge that depth gives: jumps, convex and concave creases (Gupta, Arbelaez and Malik 2013)."""

from __future__ import annotations

import math
from typing import NamedTuple

import torch
import torch.nn.functional as F
from torch import Tensor

from blockstab.boundaries.facets import Facets, facets
from blockstab.boundaries.half_discs import ORIENTATIONS
from blockstab.rgbd.frame import Camera, Frame

RELIEF = ("depth", "convex", "concave")

_JUMP = (2.0, 6.0)  # explained steps: no edge below the first, a full edge above the second
_BEND = (1.0, 3.0)  # explained bends, likewise
# Twice the sine of half an angle: a bend so small is explained, for round things have it everywhere.
_ROUND = 0.2
_MISFIT = 2.5  # sensor steps: a disc that fits worse spans an edge, and its normal means nothing
_LINK = 32.0  # explained steps: sides farther apart are no one surface, and have no crease
_RADII_PX = (3, 5)  # of a disc: least, and greatest, in images from such a diagonal on:
_WIDE_PX = 800

_ACROSS = ((1, 0), (1, 1), (0, 1), (-1, 1))  # rows and columns of a step from the first to the second side
_NEAR = (2, 1)  # steps to a side's nearest point
_MARGIN_PX = _RADII_PX[1]
_HORIZON = 1e3  # metres


class _Side(NamedTuple):
    """The surface on one side of every pixel; all float32, three coordinates as (3, H, W), others as (H, W)."""

    normal: Tensor
    distance: Tensor  # of the plane, metres; infinite where none is known
    center: Tensor  # the point of the plane in the middle of the disc
    smooth: Tensor  # 1 where the plane fits, else 0
    near: Tensor  # the mean point beside the pixel
    measured: Tensor  # 1 where it has depth, else 0


def relief(frame: Frame) -> Tensor:
    """Jumps and bends between the surfaces on the two sides of each pixel, at the four orientations.

    Planes are fitted to two discs that touch in the pixel, one on either side of the edge.

    * A jump is how far the points next to the pixel lie from the plane of the other side, the nearer of the two: a
      disc that spans another edge invents none. In a narrow shadow, where the pixel has no depth, it is how far apart
      the two planes pass. It counts in steps that need no edge: of the sensor, or of a crease between two pixels.
      Gupta et al. take the distance in metres above 1.05 sensor steps, which a table-top calls for less.
    * A crease is the difference of the two normals, convex or concave. It counts in bends that one such step across a
      disc makes, if that is more than round things have, and only where a step farther to either side has it too.

    The discs of Gupta et al. are half ellipses, at four scales; one disc serves four orientations, and a second scale
    did not gain anything on simulated scenes. In images of less than 640 x 480 pixels discs are smaller, as are the
    ledges on which things stand.

    Returns:
        (3, 4, H, W) float32, 0 to 1: `RELIEF`, each at the orientations of `BoundaryMap`.
    """
    camera, depth = frame.camera, frame.depth.float()
    height, width = depth.shape
    x = (torch.arange(width, dtype=depth.dtype) - camera.cx) / camera.fx
    y = ((torch.arange(height, dtype=depth.dtype) - camera.cy) / camera.fy)[:, None]
    measured = (depth > 0).to(depth.dtype)
    inverse = depth.clamp(min=1.0 / _HORIZON).reciprocal_().mul_(measured)
    radius = min(max(round(_RADII_PX[1] * math.hypot(height, width) / _WIDE_PX), _RADII_PX[0]), _RADII_PX[1])
    planes = facets(inverse, x, y, camera, radius)
    surface = F.pad(_packed(planes, inverse, measured, x, y, camera.noise.step), (_MARGIN_PX,) * 4)
    found = depth.new_empty(len(RELIEF), ORIENTATIONS, height, width)
    for k in range(ORIENTATIONS):
        first, second = _sides(surface, k, radius)
        jump = _jump(first, second, camera)
        jump.mul_(measured).add_(_shadow(first, second, x, y, camera).mul_(1.0 - measured))
        bend = _bend(first, second, camera, radius)
        found[0, k] = _ramp(jump, *_JUMP)
        found[1, k] = _ramp(_lasting(-bend, k), *_BEND)
        found[2, k] = _ramp(_lasting(bend, k), *_BEND)
    return found


def _packed(planes: Facets, inverse: Tensor, measured: Tensor, x: Tensor, y: Tensor, step: float) -> Tensor:
    """(12, H, W): the fields of `_Side`, not yet moved to a side."""
    smooth = ((planes.variance < (_MISFIT * step) ** 2) & (planes.distance < torch.inf)).to(inverse.dtype)
    z = _depth_along(planes.normal, planes.distance, x, y)
    means = F.avg_pool2d(torch.stack([inverse, measured])[None], 3, stride=1, padding=1)[0]
    near = means[1].div_(means[0].clamp_(min=1e-6)).mul_(measured)
    fields = [*planes.normal, planes.distance, x * z, y * z, z, smooth, x * near, y * near, near, measured]
    return torch.stack(fields)


def _sides(surface: Tensor, k: int, radius: int) -> tuple[_Side, _Side]:
    """The two sides of edges of orientation k, with discs of a radius in pixels."""
    down, right = _ACROSS[k]
    diagonal = bool(down and right)
    steps = math.ceil(radius / 2**0.5) if diagonal else radius  # to the centre of a disc

    def side(sign: int) -> _Side:
        far, near = sign * steps, sign * _NEAR[diagonal]
        plane = _moved(surface[:8], far * down, far * right, _MARGIN_PX)
        point = _moved(surface[8:], near * down, near * right, _MARGIN_PX)
        return _Side(plane[:3], plane[3], plane[4:7], plane[7], point[:3], point[3])

    return side(-1), side(1)


def _jump(first: _Side, second: _Side, camera: Camera) -> Tensor:
    """(H, W) explained steps from either side's nearest point to the other side's plane, the smaller number."""
    jump = (first.near[2] - second.near[2]).abs_()
    torch.minimum(jump, _dot(first.normal, second.near).sub_(first.distance).abs_(), out=jump)
    torch.minimum(jump, _dot(second.normal, first.near).sub_(second.distance).abs_(), out=jump)
    explained = _explained(torch.minimum(first.near[2], second.near[2]), camera)
    return jump.mul_(first.measured).mul_(second.measured).div_(explained)


def _shadow(first: _Side, second: _Side, x: Tensor, y: Tensor, camera: Camera) -> Tensor:
    """(H, W) explained steps between the two planes at the pixel itself; 0 where one does not fit."""
    z1 = _depth_along(first.normal, first.distance, x, y)
    z2 = _depth_along(second.normal, second.distance, x, y)
    # Along the ray the planes are farther apart than straight across.
    across = torch.minimum(first.distance / z1.clamp(min=1e-6), second.distance / z2.clamp(min=1e-6))
    jump = (z1 - z2).abs_().mul_(across.clamp_(max=1.0)).div_(_explained(torch.minimum(z1, z2), camera))
    return jump.mul_(first.smooth).mul_(second.smooth)


def _bend(first: _Side, second: _Side, camera: Camera, radius: int) -> Tensor:
    """(H, W) explained bends from the first side to the second: above 0 where concave, below 0 where convex."""
    offset = second.center - first.center
    length = _dot(offset, offset).sqrt_().clamp_(min=1e-6)
    depth = torch.minimum(first.center[2], second.center[2]).clamp_(min=1.0 / _HORIZON)
    explained = _explained(depth, camera)
    bend = _dot(second.normal - first.normal, offset).div_(length).mul_(first.smooth).mul_(second.smooth)
    bend.mul_(length < _LINK * explained)
    # A plane seen at a slant shows more of itself in a disc, and the same step tilts it less.
    slant = torch.minimum(first.distance, second.distance).clamp_(max=_HORIZON).div_(depth)
    unit = slant.mul_(explained).div_(depth).mul_(camera.fx / (2 * radius - 1))
    return bend.div_(unit.clamp_(min=_ROUND))


def _lasting(bend: Tensor, k: int) -> Tensor:
    """(H, W) the least bend of the pixel and of those a step to either side: one that noise makes is thinner."""
    down, right = _ACROSS[k]
    around = F.pad(bend, (1, 1, 1, 1))
    return torch.minimum(bend, _moved(around, down, right, 1)).minimum(_moved(around, -down, -right, 1))


def _depth_along(normal: Tensor, distance: Tensor, x: Tensor, y: Tensor) -> Tensor:
    """(H, W) where planes meet the rays (x, y, 1), metres; anywhere far away where they do not."""
    cosine = (normal[0] * x).addcmul_(normal[1], y).add_(normal[2])
    return distance.clamp(max=_HORIZON).div_(cosine.clamp_(min=1e-3))


def _explained(depth: Tensor, camera: Camera) -> Tensor:
    """(H, W) metres: what the sensor's resolution, or a crease between two pixels, can explain."""
    return torch.maximum(depth.square().mul_(camera.noise.step), depth / camera.fx).clamp_(min=1e-6)


def _ramp(value: Tensor, low: float, high: float) -> Tensor:
    return value.sub_(low).div_(high - low).clamp_(0.0, 1.0)


def _moved(padded: Tensor, down: int, right: int, margin: int) -> Tensor:
    """(..., H, W): what lies so many pixels below and to the right of each pixel of a padded image."""
    height, width = padded.shape[-2] - 2 * margin, padded.shape[-1] - 2 * margin
    return padded[..., margin + down : margin + down + height, margin + right : margin + right + width]


def _dot(a: Tensor, b: Tensor) -> Tensor:
    """Sum over the first dimension of a * b; ten times as fast as a reduction across planes."""
    return (a[0] * b[0]).addcmul_(a[1], b[1]).addcmul_(a[2], b[2])
