"""What a camera sees of a set of boxes: exact depth, box, face and normal at every pixel."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import torch
from torch import Tensor

from blockstab.boxes.box import Boxes

NOTHING = -1  # the box index where a ray meets none
_SKIN = (
    1e-3  # a surface this near the end of a shadow ray (metres, or share of the ray) casts no shadow on it
)

# Two triangles per face, numbered as in `Boxes`: face 2 * k looks along +axis k, and corner c has the signs
# of the bits of c.
_TRIANGLES = torch.tensor(
    [
        [[a | bit, a | bit | p, a | bit | p | q], [a | bit, a | bit | p | q, a | bit | q]]
        for bit_of_axis, p, q in ((4, 2, 1), (2, 4, 1), (1, 4, 2))
        for a, bit in ((0, bit_of_axis), (0, 0))
    ]
).flatten(0, 1)


@dataclass(frozen=True)
class Surfaces:
    """What H x W rays meet first.

    Args:
        depth: (H, W) float64, in lengths of the ray's direction; 0 where it meets nothing.
        box: (H, W) int64 index of the box, `NOTHING` where it meets none.
        face: (H, W) int64 face of the box, numbered as in `Boxes`.
        points: (H, W, 3) float64, metres; the origin of the rays where they meet nothing.
        normals: (H, W, 3) float64 outward unit normals; zero where the rays meet nothing.
    """

    depth: Tensor
    box: Tensor
    face: Tensor
    points: Tensor
    normals: Tensor


class RayCaster:
    """Rays against N boxes, with the ray casting of Open3D (Zhou et al. 2018)."""

    def __init__(self, boxes: Boxes) -> None:
        import open3d

        self._open3d = open3d
        self._boxes = boxes
        # One thread: scenes run side by side, and one scene gains little from more.
        self._scene = open3d.t.geometry.RaycastingScene(nthreads=1)
        corner = (8 * torch.arange(len(boxes)))[:, None, None]
        triangles = (corner + _TRIANGLES).flatten(0, 1).to(torch.int32).numpy().astype("uint32")
        vertices = boxes.corners().flatten(0, 1).to(torch.float32).numpy()
        self._scene.add_triangles(open3d.core.Tensor(vertices), open3d.core.Tensor(triangles))

    def first_hit(self, origin: Tensor, directions: Tensor) -> Surfaces:
        """What the rays from `origin` (3,) along `directions` (H, W, 3), both metres, meet first."""
        answer = self._scene.cast_rays(self._rays(origin, directions), nthreads=1)
        triangle = torch.from_numpy(answer["primitive_ids"].numpy().astype("int64"))
        hit = torch.from_numpy(answer["t_hit"].numpy()).isfinite()
        box = torch.where(hit, triangle // 12, NOTHING)
        face = torch.where(hit, triangle % 12 // 2, 0)
        normals = self._boxes.face_normals()[box, face] * hit[..., None]
        # Open3D answers in float32; the plane of the face gives the depth to full precision.
        ahead = ((self._boxes.face_centers()[box, face] - origin) * normals).sum(dim=-1)
        depth = torch.where(hit, ahead / (directions * normals).sum(dim=-1), 0.0)
        return Surfaces(depth, box, face, origin + depth[..., None] * directions, normals)

    def hidden_from(self, source: Tensor, points: Tensor) -> Tensor:
        """Whether a box stands between `source` (3,) and each of the points (H, W, 3), (H, W) bool."""
        return self._blocked(source, points - source, 0.0, 1.0 - _SKIN)

    def shaded_from(self, direction: Tensor, points: Tensor) -> Tensor:
        """Whether a box stands anywhere along the unit `direction` (3,) from each of the points (H, W, 3)."""
        return self._blocked(points, direction.expand_as(points), _SKIN, float("inf"))

    def _blocked(self, origin: Tensor, directions: Tensor, near: float, far: float) -> Tensor:
        rays = self._rays(origin, directions)
        return torch.from_numpy(self._scene.test_occlusions(rays, near, far, nthreads=1).numpy())

    def _rays(self, origin: Tensor, directions: Tensor) -> Any:
        rays = torch.cat([origin.expand_as(directions), directions], dim=-1)
        return self._open3d.core.Tensor(rays.to(torch.float32).numpy())
