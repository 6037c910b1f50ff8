"""The segments of several scenes in one table, so that many scenes are understood in one batch."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import torch
from torch import Tensor

from blockstab.boxes.fitting import Fits
from blockstab.boxes.separation import Separation
from blockstab.rgbd.ground import Ground
from blockstab.scene import Pairs, Scene
from blockstab.segments.atoms import Atoms
from blockstab.segments.segmentation import Segment, Segmentation
from blockstab.stability.balance import Balance
from blockstab.stability.support import Supports


@dataclass(frozen=True)
class Judged:
    """Relations and verdicts over a table of boxes: all candidates, those that count, and which boxes stand."""

    candidates: Supports
    supports: Supports
    balance: Balance


@dataclass(frozen=True)
class Union:
    """Several segmentations as one table of N segments, without any relation across them.

    Args:
        segmentations: S of them.
        segments: N, scene after scene.
        start: (S + 1) where the segments of each begin.
        first, second: (P,) every pair of segments within a scene.
        pair_start: (S + 1) where the pairs of each begin.
        neighbours: (P,) bool, whether the two share a border in the image.
    """

    segmentations: tuple[Segmentation, ...]
    segments: tuple[Segment, ...]
    start: tuple[int, ...]
    first: Tensor
    second: Tensor
    pair_start: tuple[int, ...]
    neighbours: Tensor

    @staticmethod
    def of(segmentations: Sequence[Segmentation], atoms: Atoms) -> Union:
        """The union of segmentations of the same atoms; at least one."""
        start, pair_start, first, second, touching = [0], [0], [], [], []
        for one in segmentations:
            a, b = torch.triu_indices(len(one), len(one), offset=1)
            near = torch.zeros(len(one), len(one), dtype=torch.bool)
            left, right = one.neighbours(atoms)
            near[left, right] = near[right, left] = True
            touching.append(near[a, b])
            first.append(a + start[-1])
            second.append(b + start[-1])
            start.append(start[-1] + len(one))
            pair_start.append(pair_start[-1] + len(a))
        return Union(
            tuple(segmentations),
            tuple(segment for one in segmentations for segment in one.segments),
            tuple(start),
            torch.cat(first),
            torch.cat(second),
            tuple(pair_start),
            torch.cat(touching),
        )

    def divided(
        self,
        ground: Ground,
        pixels: Tensor,
        points: Tensor,
        background: Tensor,
        fits: Fits,
        apart: Separation,
        judged: Judged,
    ) -> list[Scene]:
        """One scene for each segmentation.

        Args:
            pixels, points, background, fits: N rows, of the segments; apart: P rows, of the pairs.
        """
        scenes = []
        for k, one in enumerate(self.segmentations):
            n = slice(self.start[k], self.start[k + 1])
            p = slice(self.pair_start[k], self.pair_start[k + 1])
            pairs = Pairs(
                self.first[p] - n.start,
                self.second[p] - n.start,
                apart.gap[p],
                apart.direction[p],
                self.neighbours[p],
            )
            scenes.append(
                Scene(
                    segmentation=one,
                    ground=ground,
                    pixels=pixels[n],
                    points=points[n],
                    background=background[n],
                    boxes=fits.boxes[n],
                    fit_mean=fits.mean[n],
                    fit_variance=fits.variance[n],
                    visible_share=fits.visible_share[n],
                    pairs=pairs,
                    candidates=judged.candidates.between(n.start, n.stop),
                    supports=judged.supports.between(n.start, n.stop),
                    balance=judged.balance.between(n.start, n.stop),
                )
            )
        return scenes
