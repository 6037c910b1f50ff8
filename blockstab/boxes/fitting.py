"""Boxes of minimum surface distance (paper, Algorithm 1), and the re-fit with one axis given (section 6)."""

from __future__ import annotations

from dataclasses import dataclass, replace

import torch
from torch import Tensor

from blockstab.boxes.box import Boxes, concatenate
from blockstab.boxes.extent import surface_distance
from blockstab.boxes.sampling import uniform
from blockstab.boxes.visibility import visible_share


@dataclass(frozen=True)
class PlaneTolerance:
    """Tolerance for points to belong to a plane, by their distance r from the camera.

    The tolerance is `floor_m + per_square_m * r ** 2`: the depth noise of structured-light sensors grows with the
    square of depth (Khoshelham and Elberink 2012).
    """

    floor_m: float = 0.003
    per_square_m: float = 0.0035

    def at(self, points: Tensor) -> Tensor:
        """Tolerance for points (..., 3) seen from the origin, (...) metres."""
        return self.floor_m + self.per_square_m * points.square().sum(dim=-1)

    def coarser(self, times: float) -> PlaneTolerance:
        """The same for depth whose step is that many times as large."""
        return replace(self, per_square_m=times * self.per_square_m)


PAPER_TOLERANCE = PlaneTolerance(floor_m=0.02, per_square_m=0.0)  # "we empirically set this threshold to 2cm"


@dataclass(frozen=True)
class Fits:
    """N fitted boxes and how well they fit.

    Args:
        boxes: N boxes in the frame of the points.
        mean, variance: (N,) of the distance of a point to its nearest face, metres and square metres.
        visible_share: (N,) share of the points whose nearest face the camera sees (section 4.2).
    """

    boxes: Boxes
    mean: Tensor
    variance: Tensor
    visible_share: Tensor

    @staticmethod
    def none() -> Fits:
        """No fits."""
        empty = torch.empty(0, 3, dtype=torch.float64)
        return Fits(Boxes(empty, torch.empty(0, 3, 3, dtype=torch.float64), empty), *empty.T)

    def __len__(self) -> int:
        return len(self.mean)

    def __getitem__(self, rows: Tensor) -> Fits:
        return Fits(self.boxes[rows], self.mean[rows], self.variance[rows], self.visible_share[rows])

    def with_boxes(self, boxes: Boxes) -> Fits:
        """Other boxes for the same points, their fit taken as it was."""
        return Fits(boxes, self.mean, self.variance, self.visible_share)

    def extended(self, more: Fits) -> Fits:
        """These fits with others after them."""
        return Fits(
            concatenate([self.boxes, more.boxes]),
            torch.cat([self.mean, more.mean]),
            torch.cat([self.variance, more.variance]),
            torch.cat([self.visible_share, more.visible_share]),
        )


def judged(boxes: Boxes, points: Tensor, present: Tensor) -> Fits:
    """Say how well given boxes fit points (N, P, 3), of which those `present` (N, P) count."""
    distance = surface_distance(boxes.local(points), boxes.half_extent[:, None])
    mean = masked_mean(distance[..., None], present)[:, 0]
    variance = masked_mean((distance - mean[:, None]).square()[..., None], present)[:, 0]
    return Fits(boxes, mean, variance, visible_share(boxes, points, present))


@dataclass(frozen=True)
class MinimumSurface:
    """Algorithm 1, with its constants.

    Each restart finds a plane by RANSAC, then a plane perpendicular to it among the points left over; the
    restart whose box has the least summed distance wins. Its three axes are then refined together by least squares.

    Args:
        restarts: M of Algorithm 1.
        samples: RANSAC samples per plane ("repeated for 10 times").
        judged_points: points that choose among the restarts; the chosen box is finished on all of them.
        max_points: points of a segment that are used at all.
        outlier_share: share of the points that may stay outside the box ("up to 5% outliers").
        tolerance: distance to a plane within which a point belongs to it.
    """

    restarts: int = 15
    samples: int = 10
    judged_points: int = 256
    max_points: int = 2000
    outlier_share: float = 0.05
    tolerance: PlaneTolerance = PlaneTolerance()

    def coarser(self, times: float) -> MinimumSurface:
        """The same for depth whose step is that many times as large."""
        return replace(self, tolerance=self.tolerance.coarser(times))

    def __call__(self, points: Tensor, count: Tensor, seed: Tensor, axis: Tensor | None = None) -> Fits:
        """Fit one box to each set of points so that the points lie close to its faces.

        Args:
            points: (N, P, 3) metres from the camera, in random order; rows past `count` are ignored.
            count: (N,) int64 points of each set, at least 1.
            seed: (N,) int64; the same seed and points give the same box, to the bit, whatever else is in the batch.
            axis: (N, 3) unit vectors; where given, the first plane's normal is this one (the paper's Supp-surf).
        """
        # Importing numba takes half a second, and most of the package does without it.
        from blockstab.boxes.compiled.fits import Constants, fitted

        check(points, count)
        constants = Constants(
            self.judged_points, self.outlier_share, self.tolerance.floor_m, self.tolerance.per_square_m
        )
        given = (points, count, self.draws(seed, axis is not None))
        axes = None if axis is None else axis.contiguous().numpy()
        found = fitted(*(values.contiguous().numpy() for values in given), axes, constants)
        center, rotation, half, *fit = map(torch.from_numpy, found)
        return Fits(Boxes(center, rotation, half), *fit)

    def draws(self, seed: Tensor, follow: bool) -> Tensor:
        """The uniform numbers, (N, restarts, samples, 5), that choose the samples of sets with these seeds (N,).

        Args:
            follow: an axis is given.
        """
        numbers = uniform(seed, self.restarts * self.samples * 5, stream=int(follow))
        return numbers.view(len(seed), self.restarts, self.samples, 5)


def check(points: Tensor, count: Tensor) -> None:
    """Raises ValueError where sets of points (N, P, 3) and their counts (N,) do not fit together."""
    if points.ndim != 3 or points.shape[2] != 3 or count.shape != points.shape[:1]:
        raise ValueError(
            "Box fitting needs points (N, P, 3) and counts (N,), "
            f"but got {tuple(points.shape)} and {tuple(count.shape)}."
        )
    wrong = (count < 1) | (count > points.shape[1])
    if bool(wrong.any()):
        i = int(wrong.nonzero()[0])
        raise ValueError(
            f"Every set needs 1 to {points.shape[1]} points, but set {i} says it has {int(count[i])}."
        )


def masked_mean(values: Tensor, present: Tensor) -> Tensor:
    """Mean over the points that are present: (N, P, D) and (N, P) to (N, D)."""
    weight = present.to(values.dtype)[..., None]
    return (values * weight).sum(dim=1) / weight.sum(dim=1)
