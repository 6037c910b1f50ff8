"""Convex polygons in the plane, in batches: hull, clip, area, centroid, signed distance."""

from __future__ import annotations

from dataclasses import dataclass

from torch import Tensor


@dataclass(frozen=True)
class Polygons:
    """B convex polygons, each with up to V vertices.

    Args:
        vertices: (B, V, 2) metres, counter-clockwise. Rows past `count` repeat the last true vertex
            (zero where there is none).
        count: (B,) int64 true vertices of each: 0 is empty, 1 a point, 2 a segment (both of area zero).
    """

    vertices: Tensor
    count: Tensor

    def __len__(self) -> int:
        return self.count.shape[0]
