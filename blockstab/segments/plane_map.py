"""Planes of an image and the pixels that lie on each (after Silberman et al. 2012)."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import torch
from torch import Tensor

from blockstab.rgbd.cloud import Cloud
from blockstab.segments.pieces import without_small_pieces
from blockstab.segments.plane_labels import grown, nearest_plane, smoothed
from blockstab.segments.plane_votes import Pixels, Vote, every, fitted, moments

_WINDOW_PX = 121  # normals come from windows of so many: in fewer pixels they agree, whatever is there
_LEAST_VOTES = 8
_MERGE_STRIDE, _FIT_STRIDE = 4, 2  # pixels


@dataclass(frozen=True)
class PlaneMap:
    """The planes of an image.

    Args:
        label: (H, W) int64, 0 = no plane, planes from 1, the one with the most pixels first.
        planes: (P, 4) float64 unit normal n towards the camera and d, with n . p + d = 0, metres.
    """

    label: Tensor
    planes: Tensor


@dataclass(frozen=True)
class PlaneFinder:
    """Planes by vote: the table and walls first, then what they leave, at closer and closer look.

    Numbers of pixels are for an image of 640 x 480; others are scaled with its area.

    Args:
        reach: how far from a plane a pixel may lie, of its depth; a step of the sensor if that is more.
        tilt: one less the cosine of the angle that the normals of pixel and plane may differ by.
        bend: the same of the mean over a plane. Patches of round things have more, and are no planes.
        lean: the same of the normal of a plane and the mean one of its pixels. Planes across two parallel faces, one
            a little before the other, have more.
        least_px: pixels of a plane that are on no larger one.
        fresh_share: their share of all of its pixels.
        merge_share, merge_tilt: planes are one where such a share of the pixels of either lie within reach of the
            other, and their normals differ no more.
        piece_px: a smaller connected piece of a plane is none.
        strides: pixels between those that vote, in each look.
        budget: of votes in a look; more take longer, and find a few more small planes.
    """

    reach: float = 0.0075
    tilt: float = 0.1
    bend: float = 0.015
    lean: float = 0.003
    least_px: int = 200
    fresh_share: float = 0.5
    merge_share: float = 0.5
    merge_tilt: float = 0.01
    piece_px: int = 150
    strides: tuple[int, ...] = (8, 4, 3)
    budget: int = 2_500_000

    def __post_init__(self) -> None:
        if (
            least := min(self.reach, self.tilt, self.least_px, self.piece_px, self.budget, *self.strides)
        ) <= 0:
            raise ValueError(f"The numbers of a plane finder must be above 0, but one is {least}; raise it.")

    def __call__(self, cloud: Cloud) -> PlaneMap:
        """Find the planes of an image, in the frame of its points.

        In the end every pixel takes the nearest plane that its normal agrees with; next to edges, where normals
        are of both sides, the nearest of those beside it. Silberman et al. let a graph cut decide.
        """
        scale = math.sqrt(cloud.depth.numel() / (480 * 640))
        known = cloud.valid & (cloud.normals != 0).any(dim=2)
        # Beyond some distance a step of the sensor is more than the reach, and normals are mostly noise.
        blur = (cloud.noise.step * cloud.depth / self.reach).clamp(min=1.0)
        reach = self.reach * cloud.depth * blur
        planes = self._voted(partial(every, known=known, cloud=cloud, reach=reach, blur=blur), scale)
        if not len(planes):
            return PlaneMap(torch.zeros_like(known, dtype=torch.int64), planes)
        label = smoothed(nearest_plane(cloud, reach, planes, self.tilt), cloud, reach, planes, self.tilt)
        label = grown(without_small_pieces(label, self.piece_px * scale**2), cloud, reach, planes)
        pixels = torch.bincount(label.flatten(), minlength=len(planes) + 1)[1:]
        order = pixels.argsort(descending=True, stable=True)[: int((pixels > 0).sum())]
        number = torch.zeros(len(planes) + 1, dtype=torch.int64)
        number[order + 1] = torch.arange(1, len(order) + 1)
        label = number[label]
        return PlaneMap(label, _fitted_again(planes[order], label, cloud, reach))

    def _voted(self, pixels_of: Callable[[int], Pixels], scale: float) -> Tensor:
        """(P, 4) planes, the largest first, from the pixels at a stride."""
        vote = Vote(self.tilt, self.bend, self.lean, self.fresh_share, self.budget)
        least_px = max(self.least_px * scale**2, _WINDOW_PX)
        planes = torch.zeros(0, 4, dtype=torch.float64)
        for stride in self.strides:
            scaled = _scaled(stride, scale)
            pixels = pixels_of(scaled)
            left = pixels[~pixels.on(planes, self.tilt).any(dim=1)]
            planes = torch.cat([planes, vote(left, max(least_px / scaled**2, _LEAST_VOTES))])
        return self._merged(pixels_of(_scaled(_MERGE_STRIDE, scale)), planes)

    def _merged(self, pixels: Pixels, planes: Tensor) -> Tensor:
        """The planes without those that are one with a larger one."""
        on = pixels.on(planes, self.tilt).float()
        count = on.sum(dim=0)
        share = on.T @ on / count.clamp(min=1.0)[:, None]
        parallel = planes[:, :3] @ planes[:, :3].T > 1.0 - self.merge_tilt
        same = parallel & (torch.maximum(share, share.T) > self.merge_share)
        kept: list[int] = []
        for plane in count.argsort(descending=True, stable=True).tolist():
            if not bool(same[plane, kept].any()):
                kept.append(plane)
        return planes[kept]


def find_planes(cloud: Cloud) -> PlaneMap:
    """The planes of an image, in the frame of its points."""
    return PlaneFinder()(cloud)


def _scaled(stride: int, scale: float) -> int:
    return max(1, round(stride * scale))


def _fitted_again(planes: Tensor, label: Tensor, cloud: Cloud, reach: Tensor) -> Tensor:
    """(P, 4) the planes of least squared distance to the pixels that have their label."""
    part = (slice(None, None, _FIT_STRIDE),) * 2
    chosen = label[part] > 0
    plane = label[part][chosen] - 1
    terms = moments(cloud.points[part][chosen], reach[part][chosen] ** -2)
    sums = torch.zeros(len(planes), terms.shape[1], dtype=torch.float64).index_add(0, plane, terms)
    many = torch.bincount(plane, minlength=len(planes)) >= _LEAST_VOTES
    result = planes.clone()
    result[many] = fitted(sums[many])
    return result
