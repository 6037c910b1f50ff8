"""A 3-D point and a normal for every pixel with depth."""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import product

import torch
import torch.nn.functional as F
from kornia.geometry.depth import depth_to_3d_v2, unproject_meshgrid
from torch import Tensor

from blockstab.rgbd.frame import Frame
from blockstab.rgbd.noise import KINECT, DepthNoise

_RADIUS_PX = 5  # half width of a facet
_MISFIT = 0.03  # of the inverse depth: a facet that fits worse spans an edge, and its normal means nothing


@dataclass(frozen=True)
class Cloud:
    """An organised point cloud; the camera centre is the origin of the camera and the world frame alike.

    Args:
        points: (H, W, 3) float64, metres; zero where invalid.
        normals: (H, W, 3) float64 unit vectors towards the camera; zero where unknown.
        valid: (H, W) bool, where the sensor measured depth.
        depth: (H, W) float64, metres along the optical axis; 0 where invalid. Rotation does not change it.
        noise: of depth.
    """

    points: Tensor
    normals: Tensor
    valid: Tensor
    depth: Tensor
    noise: DepthNoise = KINECT

    def rotated(self, rotation: Tensor) -> Cloud:
        """The same cloud in a frame turned by `rotation` (3, 3)."""
        return replace(self, points=self.points @ rotation.T, normals=self.normals @ rotation.T)


def cloud_from_frame(frame: Frame) -> Cloud:
    """Back-project every pixel with depth, and find the surface normal there.

    Normals come from facets (Haralick and Watson 1981, "A facet model for image data"): a plane is fitted
    to every 11 x 11 window, and a pixel takes the best of nine windows that hold it, so a window beside an
    edge or a crease is preferred to one across it. On a plane the normal is exact, whatever pixels are
    missing. It stays unknown where every window has depth in less than an eighth of its pixels, or spans
    an edge.

    Convention:
        Camera frame: pixel (u, v), the column and row of its centre, with depth z is the point
        ((u - cx) z / fx, (v - cy) z / fy, z).
    """
    camera = frame.camera
    matrix = [[camera.fx, 0.0, camera.cx], [0.0, camera.fy, camera.cy], [0.0, 0.0, 1.0]]
    intrinsics = frame.depth.new_tensor(matrix)[None]
    rays = unproject_meshgrid(
        *frame.depth.shape, intrinsics, device=frame.depth.device, dtype=frame.depth.dtype
    )
    points = depth_to_3d_v2(frame.depth[None], intrinsics, xyz_grid=rays)[0]
    normals = _facet_normals(frame.depth, rays[0], camera.noise.deviation)
    return Cloud(points, normals, frame.depth > 0, frame.depth, camera.noise)


def _facet_normals(depth: Tensor, rays: Tensor, noise: float) -> Tensor:
    """(H, W, 3) unit normals from (H, W) depth, whose inverse errs by `noise`, and the rays that end at z = 1."""
    x, y = rays[..., 0].contiguous(), rays[..., 1].contiguous()
    inverse = torch.where(depth > 0, 1.0 / depth, 0.0)
    planes, variance = _window_planes(inverse, x, y)
    height, width = depth.shape
    stride = width + 2 * _RADIUS_PX

    # Windows are ranked in single precision, which is finer than any sensor; the planes keep theirs.
    padded = F.pad(planes, (_RADIUS_PX,) * 4)
    a, b, c = padded.float()
    spread = F.pad(variance.float(), (_RADIUS_PX,) * 4, value=torch.inf)
    xs, ys, measured = x.float(), y.float(), inverse.float()
    best = torch.full_like(measured, torch.inf)
    choice = torch.zeros_like(measured, dtype=torch.int64)
    # The centred window comes first: it wins where several fit to within the sensor's noise.
    for row, column in product((_RADIUS_PX, 0, 2 * _RADIUS_PX), repeat=2):
        window = (slice(row, row + height), slice(column, column + width))
        miss = torch.addcmul(c[window] - measured, a[window], xs).addcmul_(b[window], ys)
        misfit = torch.addcmul(spread[window], miss, miss).clamp_(min=noise**2)
        choice.masked_fill_(misfit < best, row * stride + column)
        best = torch.minimum(best, misfit)

    here = torch.arange(height, device=depth.device)[:, None] * stride + torch.arange(
        width, device=depth.device
    )
    facet = padded[:3].flatten(1)[:, choice + here]
    known = (depth > 0) & (best < (_MISFIT * measured) ** 2)
    scale = torch.where(known, -facet.square().sum(0).rsqrt(), 0.0)
    return (facet * scale).permute(1, 2, 0).contiguous()


def _window_planes(inverse: Tensor, x: Tensor, y: Tensor) -> tuple[Tensor, Tensor]:
    """Least-squares plane of the window around every pixel: (3, H, W) coefficients, (H, W) residual variance.

    A plane n . p = d has inverse depth a x + b y + c along the ray (x, y, 1), where (a, b, c) = n / d; so the
    fit is linear, its weights are even for a disparity sensor, and its coefficients are the normal,
    unnormalised. The variance is infinite where the window holds too little to fit.
    """
    mask = (inverse > 0).to(inverse.dtype)
    mx, my, qx, qy = mask * x, mask * y, inverse * x, inverse * y
    terms = [mask, mx, my, inverse, mx * x, mx * y, my * y, qx, qy, inverse * inverse]
    count, *sums = _window_sums(torch.stack(terms))
    share = 1.0 / count.clamp(min=1.0)
    x0, y0, q0, xx, xy, yy, qx, qy, qq = (total * share for total in sums)
    xx, xy, yy = xx - x0 * x0, xy - x0 * y0, yy - y0 * y0
    qx, qy, qq = qx - q0 * x0, qy - q0 * y0, qq - q0 * q0

    determinant = xx * yy - xy * xy
    # A window whose pixels lie along a line leaves the plane free to turn about it.
    enough = (count >= (2 * _RADIUS_PX + 1) ** 2 / 8) & (determinant > 0.01 * (xx + yy) ** 2)
    determinant = torch.where(enough, determinant, 1.0)
    a = (yy * qx - xy * qy) / determinant
    b = (xx * qy - xy * qx) / determinant
    variance = torch.where(enough, qq - a * qx - b * qy, torch.inf)
    return torch.stack([a, b, q0 - a * x0 - b * y0]), variance


def _window_sums(images: Tensor) -> Tensor:
    """(K, H, W) sums over the window around every pixel; outside the image everything is zero."""
    size = 2 * _RADIUS_PX + 1
    sums = F.pad(images, (_RADIUS_PX + 1, _RADIUS_PX) * 2).cumsum(-1)
    sums = (sums[..., size:] - sums[..., :-size]).cumsum(-2)
    return sums[..., size:, :] - sums[..., :-size, :]
