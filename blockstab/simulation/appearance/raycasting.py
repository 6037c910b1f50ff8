"""Ray casting of a pile: exact depth, solid, patch and normal along every ray."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import torch
from torch import Tensor

from blockstab.simulation.appearance.meshes import Patch, mesh_of
from blockstab.simulation.physics.solids import Pile

NOTHING = -1  # the solid where a ray meets none
_SKIN = 1e-3  # a surface this near an end of a shadow ray (metres, or share of the ray) casts no shadow on it


@dataclass(frozen=True)
class Surfaces:
    """Surfaces that rays of any shape (...) meet first.

    Args:
        depth: (...) float64, in lengths of the ray's direction; 0 where it meets nothing.
        solid: (...) int64 index of the solid, `NOTHING` where it meets none.
        patch: (...) int64 patch of the solid, as `mesh_of` numbers them; the face of a box.
        points: (..., 3) float64, metres; the origin of the rays where they meet nothing.
        normals: (..., 3) float64 outward unit normals, smooth on what is round; zero where a ray meets nothing.
        uv: (..., 2) float32 metres on the patch.
    """

    depth: Tensor
    solid: Tensor
    patch: Tensor
    points: Tensor
    normals: Tensor
    uv: Tensor

    def __getitem__(self, index: Any) -> Surfaces:
        fields = (self.depth, self.solid, self.patch, self.points, self.normals, self.uv)
        return Surfaces(*(field[index] for field in fields))


class RayCaster:
    """Rays against N solids, with the ray casting of Open3D (Zhou et al. 2018).

    Attributes:
        patches: of each solid, in order.
    """

    patches: tuple[tuple[Patch, ...], ...]

    def __init__(self, pile: Pile) -> None:
        import open3d

        self._open3d = open3d
        meshes = [mesh_of(solid) for solid in pile.solids]
        self.patches = tuple(mesh.patches for mesh in meshes)
        self._corners = torch.cat(
            [mesh.corners @ r.T + c for mesh, r, c in zip(meshes, pile.rotation, pile.center, strict=True)]
        )
        self._normals = torch.cat([mesh.normals @ r.T for mesh, r in zip(meshes, pile.rotation, strict=True)])
        self._uv = torch.cat([mesh.uv for mesh in meshes]).to(torch.float32)
        self._patch = torch.cat([mesh.patch for mesh in meshes])
        count = torch.tensor([len(mesh.patch) for mesh in meshes])
        self._solid = torch.arange(len(pile)).repeat_interleave(count)
        sides = self._corners[:, 1:] - self._corners[:, :1]
        plane = torch.linalg.cross(sides[:, 0], sides[:, 1])
        self._plane = plane / plane.norm(dim=-1, keepdim=True)
        # One thread: scenes run side by side, and one scene gains little from more.
        self._scene = open3d.t.geometry.RaycastingScene(nthreads=1)
        vertices = self._corners.flatten(0, 1).to(torch.float32).numpy()
        triangles = torch.arange(len(vertices)).reshape(-1, 3).numpy().astype("uint32")
        self._scene.add_triangles(open3d.core.Tensor(vertices), open3d.core.Tensor(triangles))

    def first_hit(self, origin: Tensor, directions: Tensor) -> Surfaces:
        """The surfaces that the rays from `origin` (3,) along `directions` (..., 3), both metres, meet first."""
        answer = self._scene.cast_rays(self._rays(origin, directions), nthreads=1)
        hit = torch.from_numpy(answer["t_hit"].numpy()).isfinite()
        triangle = torch.from_numpy(answer["primitive_ids"].numpy().astype("int64"))
        triangle = torch.where(hit, triangle, 0)
        place = torch.from_numpy(answer["primitive_uvs"].numpy())
        share = torch.cat([1.0 - place.sum(dim=-1, keepdim=True), place], dim=-1)[..., None]
        # Open3D answers in float32; the plane of the triangle gives the depth to full precision.
        plane = self._plane[triangle]
        ahead = ((self._corners[:, 0][triangle] - origin) * plane).sum(dim=-1)
        depth = torch.where(hit, ahead / (directions * plane).sum(dim=-1), 0.0)
        normals = (self._normals[triangle] * share).sum(dim=-2)
        normals = normals / normals.norm(dim=-1, keepdim=True)
        return Surfaces(
            depth,
            torch.where(hit, self._solid[triangle], NOTHING),
            torch.where(hit, self._patch[triangle], 0),
            origin + depth[..., None] * directions,
            normals * hit[..., None],
            (self._uv[triangle] * share).sum(dim=-2),
        )

    def meets(self, origin: Tensor, directions: Tensor) -> Tensor:
        """True where the rays from `origin` (3,) along `directions` (..., 3) meet anything, (...) bool."""
        return self._blocked(origin, directions, 0.0, float("inf"))

    def hidden_from(self, source: Tensor, points: Tensor) -> Tensor:
        """True where something stands between `source` (3,) or (..., 3) and the points (..., 3), (...) bool."""
        return self._blocked(source, points - source, 0.0, 1.0 - _SKIN)

    def shaded(self, points: Tensor, directions: Tensor, reach: float) -> Tensor:
        """True where something stands within `reach` metres of points along unit `directions` (..., 3)."""
        return self._blocked(points, directions, _SKIN, reach)

    def _blocked(self, origin: Tensor, directions: Tensor, near: float, far: float) -> Tensor:
        rays = self._rays(origin, directions)
        return torch.from_numpy(self._scene.test_occlusions(rays, near, far, nthreads=1).numpy())

    def _rays(self, origin: Tensor, directions: Tensor) -> Any:
        rays = torch.cat([origin.expand_as(directions), directions], dim=-1)
        return self._open3d.core.Tensor(rays.to(torch.float32).numpy())
