"""A plane through the disc around every pixel, and where it lies."""

from __future__ import annotations

from functools import cache
from typing import NamedTuple

import torch
import torch.nn.functional as F
from torch import Tensor

from blockstab.rgbd.frame import Camera

_FULL = 0.3  # share of a disc's pixels that must have depth


class Facets(NamedTuple):
    """The plane n . p = d through the disc around every pixel; infinitely far where none is known.

    Args:
        normal: (3, H, W) float32 unit normals n, away from the camera; zero where no plane is known.
        distance: (H, W) d, metres; infinite where no plane is known.
        variance: (H, W) of inverse depth about the plane, 1/m^2; means nothing where no plane is known.
    """

    normal: Tensor
    distance: Tensor
    variance: Tensor


def facets(inverse: Tensor, x: Tensor, y: Tensor, camera: Camera, radius: int) -> Facets:
    """Fit a plane to the disc around every pixel, by least squares over the pixels with depth.

    A plane n . p = d has inverse depth a x + b y + c along the ray (x, y, 1), where (a, b, c) = n / d; so the fit
    is linear, and even for a disparity sensor. Its sums are convolutions, with moments about the pixel.

    Args:
        inverse: (H, W) float32, 1/m; 0 where nothing was measured.
        x, y: (W,) and (H, 1) float32; the ray through a pixel is (x, y, 1).
        camera: intrinsics.
        radius: of the disc, pixels.
    """
    moments = _moments(radius)
    mask = (inverse > 0).to(inverse.dtype)
    # Padded beforehand: to pad by itself, oneDNN falls back to loops a hundred times as slow on processors with AVX2.
    around = F.pad(torch.stack([mask, inverse, inverse.square()])[:, None, None], (radius,) * 4)
    count, u, v, uu, uv, vv = F.conv2d(around[0], moments)[0]
    q, uq, vq = F.conv2d(around[1], moments[:3])[0]
    qq = F.conv2d(around[2], moments[:1])[0, 0]
    known = count >= _FULL * moments[0].sum()
    share = count.clamp(min=1.0).reciprocal_()
    for total in (u, v, uu, uv, vv, q, uq, vq, qq):
        total.mul_(share)
    uu.addcmul_(u, u, value=-1.0), uv.addcmul_(u, v, value=-1.0), vv.addcmul_(v, v, value=-1.0)
    uq.addcmul_(u, q, value=-1.0), vq.addcmul_(v, q, value=-1.0), qq.addcmul_(q, q, value=-1.0)
    determinant = (uu * vv).addcmul_(uv, uv, value=-1.0)
    # A disc whose pixels lie along a line leaves the plane free to turn about it.
    known &= determinant > (uu + vv).square_().mul_(0.02)
    sure = known.to(count.dtype)
    determinant.clamp_(min=1e-6).reciprocal_()
    du = (vv * uq).addcmul_(uv, vq, value=-1.0).mul_(determinant)
    dv = (uu * vq).addcmul_(uv, uq, value=-1.0).mul_(determinant)
    variance = qq.addcmul_(du, uq, value=-1.0).addcmul_(dv, vq, value=-1.0)
    c = q.addcmul_(du, u, value=-1.0).addcmul_(dv, v, value=-1.0)
    normal = torch.stack([du.mul_(camera.fx), dv.mul_(camera.fy), c])
    normal[2].addcmul_(normal[0], x, value=-1.0).addcmul_(normal[1], y, value=-1.0)
    distance = (normal[0] * normal[0]).addcmul_(normal[1], normal[1]).addcmul_(normal[2], normal[2])
    distance.clamp_(min=1e-12).rsqrt_()
    return Facets(normal.mul_(distance * sure), distance.div_(sure), variance)


@cache
def _moments(radius: int) -> Tensor:
    """(6, 1, K, K) float32: of each pixel of the disc 1, u, v, u u, u v, v v; u, v from the centre."""
    v, u = torch.meshgrid(*[torch.arange(-radius, radius + 1)] * 2, indexing="ij")
    inside = u * u + v * v <= radius**2
    return (torch.stack([torch.ones_like(u), u, v, u * u, u * v, v * v]) * inside)[:, None].float()
