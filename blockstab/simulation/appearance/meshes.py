"""Triangles of solids, with what a painter needs to know at each of their corners."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import torch
from torch import Tensor

from blockstab.simulation.physics.solids import Part, Solid

_ROUND = 80  # segments round a circle: a facet of a 5 cm cylinder lies within 0.04 mm of it
_CREASE = math.cos(math.radians(40.0))  # faces of hulls that meet at less than that are one smooth surface
# The directions of u and v on each face of a box: u x v looks outward, and v is up on the four sides.
_FACE_AXES = torch.tensor(
    [
        [[0, 0, -1], [0, 1, 0]],
        [[0, 0, 1], [0, 1, 0]],
        [[1, 0, 0], [0, 0, -1]],
        [[1, 0, 0], [0, 0, 1]],
        [[1, 0, 0], [0, 1, 0]],
        [[-1, 0, 0], [0, 1, 0]],
    ],
    dtype=torch.float64,
)


class Patch(NamedTuple):
    """A piece of a solid's surface that is painted as one.

    Args:
        form: of the part it belongs to.
        face: 0 to 5 of a box, numbered as in `Boxes`; 0 side, 1 top, 2 bottom of a cylinder; else 0.
        width, height: metres, the ranges of u and v on it.
        echo: of the part it belongs to.
    """

    form: str
    face: int
    width: float
    height: float
    echo: float = 1.0


class Mesh(NamedTuple):
    """T triangles of a solid, in the solid's frame, metres.

    Args:
        corners: (T, 3, 3) float64.
        normals: (T, 3, 3) float64 outward unit normals at the corners; smooth on round surfaces.
        uv: (T, 3, 2) float64 metres on the patch, from its lower left; u runs round what is round.
        patch: (T,) int64, index into `patches`.
        patches: of the solid, part after part; its hulls share one, in the place of the first.
    """

    corners: Tensor
    normals: Tensor
    uv: Tensor
    patch: Tensor
    patches: tuple[Patch, ...]


def mesh_of(solid: Solid) -> Mesh:
    """The surface of a solid. Where parts overlap, the surfaces inside others stay."""
    pieces: list[Mesh] = []
    hulls = [part for part in solid.parts if part.form == "hull"]
    for part in solid.parts:
        if part.form == "hull":
            if part is hulls[0]:
                pieces.append(_echoing(_hulls(hulls), part))
            continue
        piece = {"box": _box, "cylinder": _cylinder, "sphere": _sphere}[part.form](part.half_extent)
        corners, normals = piece.corners @ part.rotation.T + part.center, piece.normals @ part.rotation.T
        pieces.append(_echoing(piece._replace(corners=corners, normals=normals), part))
    return _joined(pieces)


def _echoing(mesh: Mesh, part: Part) -> Mesh:
    return mesh._replace(patches=tuple(patch._replace(echo=part.echo) for patch in mesh.patches))


def _joined(pieces: list[Mesh]) -> Mesh:
    first = [sum(len(piece.patches) for piece in pieces[:i]) for i in range(len(pieces))]
    return Mesh(
        torch.cat([piece.corners for piece in pieces]),
        torch.cat([piece.normals for piece in pieces]),
        torch.cat([piece.uv for piece in pieces]),
        torch.cat([piece.patch + start for piece, start in zip(pieces, first, strict=True)]),
        tuple(patch for piece in pieces for patch in piece.patches),
    )


def _box(half: Tensor) -> Mesh:
    faces = []
    for face in range(6):
        u, v = _FACE_AXES[face]
        outward = torch.linalg.cross(u, v)
        reach_u, reach_v = (u.abs() * half).sum(), (v.abs() * half).sum()
        s, t = torch.meshgrid(_ends(), _ends(), indexing="ij")
        points = outward * half + (s * reach_u)[..., None] * u + (t * reach_v)[..., None] * v
        uv = torch.stack([(s + 1) * reach_u, (t + 1) * reach_v], dim=-1)
        patch = Patch("box", face, 2 * float(reach_u), 2 * float(reach_v))
        faces.append(_grid(points, outward.expand_as(points), uv, patch))
    return _joined(faces)


def _cylinder(half: Tensor) -> Mesh:
    radius, tall = float(half[0]), float(half[1])
    angle, height = torch.meshgrid(_circle(), tall * _ends(), indexing="ij")
    out = torch.stack([angle.sin(), torch.zeros_like(angle), angle.cos()], dim=-1)
    up = torch.tensor([0.0, 1.0, 0.0], dtype=torch.float64)
    uv = torch.stack([(angle + math.pi) * radius, height + tall], dim=-1)
    side = Patch("cylinder", 0, 2 * math.pi * radius, 2 * tall)
    pieces = [_grid(radius * out + height[..., None] * up, out, uv, side)]
    for face, sign in ((1, 1.0), (2, -1.0)):
        ring = out * radius * torch.tensor([0.0, 1.0], dtype=torch.float64)[:, None]
        uv = torch.stack([ring[..., 0], -sign * ring[..., 2]], dim=-1) + radius
        disc = Patch("cylinder", face, 2 * radius, 2 * radius)
        pieces.append(_grid(ring + sign * tall * up, (sign * up).expand_as(ring), uv, disc))
    return _joined(pieces)


def _sphere(half: Tensor) -> Mesh:
    radius = float(half[0])
    above = torch.linspace(-math.pi / 2, math.pi / 2, _ROUND // 2 + 1, dtype=torch.float64)
    angle, above = torch.meshgrid(_circle(), above, indexing="ij")
    out = torch.stack([above.cos() * angle.sin(), above.sin(), above.cos() * angle.cos()], dim=-1)
    uv = torch.stack([angle + math.pi, above + math.pi / 2], dim=-1) * radius
    return _grid(radius * out, out, uv, Patch("sphere", 0, 2 * math.pi * radius, math.pi * radius))


def _grid(points: Tensor, normals: Tensor, uv: Tensor, patch: Patch) -> Mesh:
    """Two triangles for each cell of a grid (R, S) of points; none for a cell without area."""

    def split(values: Tensor) -> Tensor:
        a, b, c, d = values[:-1, :-1], values[1:, :-1], values[1:, 1:], values[:-1, 1:]
        return torch.stack([torch.stack([a, b, c], 2), torch.stack([a, c, d], 2)], 2).flatten(0, 2)

    corners = split(points)
    sides = corners[:, 1:] - corners[:, :1]
    keep = torch.linalg.cross(sides[:, 0], sides[:, 1]).norm(dim=-1) > 1e-12
    number = torch.zeros(int(keep.sum()), dtype=torch.int64)
    return Mesh(corners[keep], split(normals)[keep], split(uv)[keep], number, (patch,))


def _hulls(parts: list[Part]) -> Mesh:
    """Convex hulls as one patch that is wrapped round the y axis of their solid."""
    from scipy.spatial import ConvexHull

    corners, flat = [], []
    for part in parts:
        assert part.points is not None
        hull = ConvexHull(part.points.numpy())
        points = part.points @ part.rotation.T + part.center
        corners.append(points[torch.from_numpy(hull.simplices.astype(np.int64))])
        flat.append(torch.from_numpy(hull.equations[:, :3].copy()) @ part.rotation.T)
    triangles, normals = torch.cat(corners), torch.cat(flat)
    angle = torch.atan2(triangles[..., 0], triangles[..., 2])
    # Measured from the first corner, no triangle runs the long way round.
    angle = angle[:, :1] + (angle - angle[:, :1] + math.pi).remainder(2 * math.pi) - math.pi
    radius = float(triangles[..., [0, 2]].norm(dim=-1).max())
    low, high = triangles[..., 1].min(), triangles[..., 1].max()
    uv = torch.stack([(angle + math.pi) * radius, triangles[..., 1] - low], dim=-1)
    patch = Patch("hull", 0, 2 * math.pi * radius, float(high - low))
    number = torch.zeros(len(triangles), dtype=torch.int64)
    return Mesh(triangles, _smoothed(triangles, normals), uv, number, (patch,))


def _smoothed(triangles: Tensor, flat: Tensor) -> Tensor:
    """Normals (T, 3, 3) at the corners: the mean over all triangles that meet there at a blunt angle."""
    place = (triangles.flatten(0, 1) * 1e5).round()
    _, vertex = torch.unique(place, dim=0, return_inverse=True)
    sides = triangles[:, 1:] - triangles[:, :1]
    area = torch.linalg.cross(sides[:, 0], sides[:, 1]).norm(dim=-1)
    own = flat.repeat_interleave(3, dim=0)
    near = (vertex[:, None] == vertex) & (own @ own.T > _CREASE)
    mean = near.to(torch.float64) @ (own * area.repeat_interleave(3)[:, None])
    smooth: Tensor = mean / mean.norm(dim=-1, keepdim=True)
    return smooth.view(-1, 3, 3)


def _ends() -> Tensor:
    return torch.tensor([-1.0, 1.0], dtype=torch.float64)


def _circle() -> Tensor:
    return torch.linspace(-math.pi, math.pi, _ROUND + 1, dtype=torch.float64)
