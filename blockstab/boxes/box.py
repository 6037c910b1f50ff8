"""Oriented boxes: centre, rotation, half extent (paper, section 4)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import torch
from torch import Tensor

MIN_HALF_EXTENT = 0.005  # metres; a thinner box would make features that divide by its volume explode

_SIGNS = torch.tensor(
    [[x, y, z] for x in (-1.0, 1.0) for y in (-1.0, 1.0) for z in (-1.0, 1.0)], dtype=torch.float64
)
# Corners whose signs differ in exactly one place share an edge.
_EDGES = torch.tensor([[a, b] for a in range(8) for b in range(a + 1, 8) if (a ^ b) in (1, 2, 4)])


@dataclass(frozen=True)
class Boxes:
    """N oriented boxes in one frame.

    Args:
        center: (N, 3) metres.
        rotation: (N, 3, 3); the columns are the box axes, right-handed.
        half_extent: (N, 3) metres along each axis, at least `MIN_HALF_EXTENT`.

    Convention:
        The order of the axes carries no meaning. Face `2 * k` looks along +axis k, face `2 * k + 1`
        along -axis k.
    """

    center: Tensor
    rotation: Tensor
    half_extent: Tensor

    def __len__(self) -> int:
        return self.center.shape[0]

    def __getitem__(self, index: Tensor | slice | Sequence[int]) -> Boxes:
        return Boxes(self.center[index], self.rotation[index], self.half_extent[index])

    def corners(self) -> Tensor:
        """The corners, (N, 8, 3) metres; corner c has the signs of the bits of c, first axis first."""
        signs = _SIGNS.to(self.center)
        return self.center[:, None] + (signs * self.half_extent[:, None]) @ self.rotation.transpose(1, 2)

    def edges(self) -> Tensor:
        """The twelve edges by their two ends, (N, 12, 2, 3) metres."""
        return self.corners()[:, _EDGES.to(self.center.device)]

    def face_normals(self) -> Tensor:
        """Outward unit normals, (N, 6, 3)."""
        axes = self.rotation.transpose(1, 2)
        return torch.stack([axes, -axes], dim=2).flatten(1, 2)

    def face_centers(self) -> Tensor:
        """Centres of the six faces, (N, 6, 3) metres."""
        reach = self.half_extent.repeat_interleave(2, dim=1)
        return self.center[:, None] + self.face_normals() * reach[..., None]

    def volume(self) -> Tensor:
        """Volumes, (N,) cubic metres."""
        return 8.0 * self.half_extent.prod(dim=1)

    def local(self, points: Tensor) -> Tensor:
        """Coordinates of points (N, P, 3) along the axes of their box, from its centre, (N, P, 3) metres."""
        return (points - self.center[:, None]) @ self.rotation

    def rotated(self, rotation: Tensor) -> Boxes:
        """The same boxes after turning the whole frame by `rotation` (3, 3)."""
        return Boxes(self.center @ rotation.T, rotation @ self.rotation, self.half_extent)


def checked(boxes: Boxes) -> Boxes:
    """Return `boxes` if they are well formed.

    Raises:
        ValueError: naming the first box that is not finite, not orthonormal, left-handed, or too thin.
    """
    n = len(boxes)
    for name, shape in (("rotation", (n, 3, 3)), ("half_extent", (n, 3)), ("center", (n, 3))):
        got = tuple(getattr(boxes, name).shape)
        if got != shape:
            raise ValueError(f"Boxes of {n} centres need {name} of shape {shape}, but got {got}.")
    finite = (
        torch.cat([boxes.center, boxes.rotation.flatten(1), boxes.half_extent], dim=1).isfinite().all(dim=1)
    )
    if not bool(finite.all()):
        raise ValueError(f"Box {int((~finite).nonzero()[0])} holds a value that is not finite.")
    identity = torch.eye(3, dtype=boxes.rotation.dtype, device=boxes.rotation.device)
    skew = (boxes.rotation.transpose(1, 2) @ boxes.rotation - identity).abs().flatten(1).amax(dim=1)
    if bool((skew > 1e-6).any()):
        i = int((skew > 1e-6).nonzero()[0])
        raise ValueError(
            f"Box axes must be orthonormal columns, but those of box {i} miss it by {float(skew[i]):.1e}; "
            "make them unit vectors at right angles to each other."
        )
    det = torch.linalg.det(boxes.rotation)
    if bool((det < 0).any()):
        i = int((det < 0).nonzero()[0])
        raise ValueError(
            f"Box axes must be the columns of a rotation matrix, but the determinant of box {i} is "
            f"{float(det[i]):.3f}; negate one column to make the axes right-handed."
        )
    thin = boxes.half_extent.amin(dim=1) < MIN_HALF_EXTENT * (1 - 1e-9)
    if bool(thin.any()):
        i = int(thin.nonzero()[0])
        raise ValueError(
            f"Half extents must be at least {MIN_HALF_EXTENT} m, but those of box {i} are "
            f"{boxes.half_extent[i].tolist()}; thicken the box."
        )
    return boxes


def concatenate(parts: Sequence[Boxes]) -> Boxes:
    """One set of boxes from several, in order."""
    return Boxes(
        torch.cat([p.center for p in parts]),
        torch.cat([p.rotation for p in parts]),
        torch.cat([p.half_extent for p in parts]),
    )


def rotation_of(quaternion: Tensor) -> Tensor:
    """The rotation (3, 3) float64 of a quaternion (4,), w first, of any length but 0."""
    w, x, y, z = (quaternion / quaternion.norm()).tolist()
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    return torch.tensor(rows, dtype=torch.float64)
