"""Planes that many pixels agree on."""

from __future__ import annotations

from dataclasses import dataclass, fields

import torch
import torch.nn.functional as F
from torch import Tensor

from blockstab.rgbd.cloud import Cloud

# Pixels (row, column) with the least fractional parts of a row + b column lie evenly over an image, however many are
# taken (Roberts 2018, "The unreasonable effectiveness of quasirandom sequences").
_EVEN = (0.7548776662466927, 0.5698402909980532)


@dataclass(frozen=True)
class Pixels:
    """S pixels of an image.

    Args:
        points: (S, 3) float64, metres.
        normals: (S, 3) float64 unit vectors towards the camera.
        reach: (S,) float64, metres: how far from a plane they may lie, and still be on it.
        blur: (S,) float64, 1 and more: how much more of their normals is noise than near the sensor.
        turn: (S,) float64, 0 to 1: those with the least ones lie evenly over the image.
    """

    points: Tensor
    normals: Tensor
    reach: Tensor
    blur: Tensor
    turn: Tensor

    def __len__(self) -> int:
        return len(self.turn)

    def __getitem__(self, rows: Tensor) -> Pixels:
        return Pixels(*(getattr(self, field.name)[rows] for field in fields(self)))

    def on(self, planes: Tensor, tilt: float, reaches: float = 1.0) -> Tensor:
        """Mask of the pixels that lie on each plane.

        Args:
            planes: (P, 4) float64, normal and offset.
            tilt: one less the cosine of the angle that normals may differ by.
            reaches: how far off, in reaches.

        Returns:
            (S, P) bool.
        """
        scaled = F.pad(self.points, (0, 1), value=1.0) / (reaches * self.reach[:, None])
        # Single precision is a thousand times finer than any sensor.
        near = (scaled.float() @ planes.float().T).abs_() < 1.0
        return near.logical_and_(self.normals.float() @ planes[:, :3].float().T > 1.0 - tilt)


def every(stride: int, known: Tensor, cloud: Cloud, reach: Tensor, blur: Tensor) -> Pixels:
    """The known pixels in every `stride`-th row and column; `reach` and `blur` are (H, W), as in `Pixels`."""
    part = (slice(stride // 2, None, stride),) * 2
    chosen = known[part]
    row, column = chosen.nonzero().T
    turn = (_EVEN[0] * row + _EVEN[1] * column) % 1.0
    points, normals, reach, blur = (
        image[part][chosen] for image in (cloud.points, cloud.normals, reach, blur)
    )
    return Pixels(points, normals, reach, blur, turn)


@dataclass(frozen=True)
class Vote:
    """Vote of pixels for planes.

    Args:
        tilt: one less the cosine of the angle that normals of pixels and plane may differ by.
        bend: the same of the mean over all pixels of a plane, times their blur: patches of something round have more.
        lean: the same of the normal of a plane and the mean one of its pixels: a plane across two parallel faces, one
            a little before the other, has more.
        fresh_share: of the pixels of a plane, that are on none with more pixels.
        budget: the most questions, whether a pixel is on a plane.
    """

    tilt: float
    bend: float
    lean: float
    fresh_share: float
    budget: int

    def __call__(self, pixels: Pixels, least: float) -> Tensor:
        """Planes with at least `least` pixels that are on no larger one, (P, 4) float64, the largest first.

        Each of a number of pixels that lie evenly over the image suggests the plane through its point along its
        surface. What is nearest to it gives the plane that is voted on.
        """
        seeds = pixels[pixels.turn * len(pixels) ** 2 <= self.budget]
        guesses = torch.cat([seeds.normals, -(seeds.normals * seeds.points).sum(dim=1, keepdim=True)], dim=1)
        core = pixels.on(guesses, self.tilt, 0.5).double()
        sums = core.T @ F.pad(moments(pixels.points, pixels.reach**-2), (0, 1), value=1.0)
        planes = fitted(sums[sums[:, -1] >= max(least / 2, 3), :-1])

        on = pixels.on(planes, self.tilt).float()
        terms = torch.cat(
            [pixels.normals, pixels.blur[:, None], torch.ones_like(pixels.blur)[:, None]], dim=1
        )
        sums = on.T @ terms.float()
        count = sums[:, 4]
        means = sums[:, :4] / count.clamp(min=1.0)[:, None]
        mean, blur = means[:, :3], means[:, 3]
        cosine, length = (mean * planes[:, :3]).sum(dim=1), mean.norm(dim=1)
        right = (cosine > 1.0 - self.bend * blur) & (cosine > (1.0 - self.lean) * length)
        return planes[self._kept(on, torch.where(right, count, 0.0), least)]

    def _kept(self, on: Tensor, count: Tensor, least: float) -> list[int]:
        """Of planes with the pixels `on` (S, P), `count` (P,) of them: those that bring enough new ones, in order."""
        fresh, free, kept = count, torch.ones(len(on), dtype=torch.bool), list[int]()
        while bool((candidates := (fresh >= least) & (fresh >= self.fresh_share * count)).any()):
            kept.append(int(torch.where(candidates, count, -1.0).argmax()))
            taken = (on[:, kept[-1]] > 0) & free
            free = free & ~taken
            fresh = fresh - on[taken].sum(dim=0)
        return kept


def moments(points: Tensor, weight: Tensor) -> Tensor:
    """(N, 10): the weight, and its products with x, y, z, xx, xy, xz, yy, yz and zz of (N, 3) points."""
    x, y, z = points.T
    products = [torch.ones_like(x), x, y, z, x * x, x * y, x * z, y * y, y * z, z * z]
    return torch.stack([weight * product for product in products], dim=1)


def fitted(sums: Tensor) -> Tensor:
    """(P, 4) float64: the planes of least squared distance to points with the sums (P, 10) of `moments`.

    Normals have unit length and point towards the camera.
    """
    mean = sums[:, 1:] / sums[:, :1]
    center, second = mean[:, :3], mean[:, [3, 4, 5, 4, 6, 7, 5, 7, 8]].view(-1, 3, 3)
    normal = torch.linalg.eigh(second - center[:, :, None] * center[:, None, :]).eigenvectors[:, :, 0]
    offset = -(normal * center).sum(dim=1, keepdim=True)
    return torch.cat([normal, offset], dim=1) * torch.where(offset < 0, -1.0, 1.0)
