"""Boxes seen by a camera at the origin, and points on the faces it sees: what a fit should recover."""

from __future__ import annotations

from itertools import permutations

import torch
from torch import Tensor

from blockstab.boxes.box import Boxes
from blockstab.boxes.box_cache import BoxFitter
from blockstab.boxes.fitting import Fits, MinimumSurface
from blockstab.boxes.visibility import visible_faces

POINTS = 2000  # of each box, where a test does not say otherwise
_ORDERS = torch.tensor(list(permutations(range(3))))


def boxes_showing(faces: int, number: int, generator: torch.Generator) -> Boxes:
    """Boxes of 6 to 30 cm, turned at random, a metre from a camera that sees so many faces of each."""

    def random() -> Tensor:
        return torch.rand(number, 3, generator=generator, dtype=torch.float64)

    half = 0.03 + 0.12 * random()
    sideways = (random() - 0.5) * half  # where the camera is along the axes whose faces it cannot see
    outward = 0.4 + 0.6 * random()
    seen = torch.arange(3) < faces
    rest = (1 - (sideways.square() * ~seen).sum(dim=1, keepdim=True)).sqrt()
    outward = outward * seen
    outward = outward / outward.norm(dim=1, keepdim=True) * rest
    sign = torch.where(random() < 0.5, -1.0, 1.0)
    camera = torch.where(seen, outward * sign, sideways)
    rotation = random_turns(number, generator)
    return Boxes(-(rotation @ camera[..., None])[..., 0], rotation, half)


def random_turns(number: int, generator: torch.Generator) -> Tensor:
    """Rotations (number, 3, 3)."""
    basis = torch.linalg.qr(torch.randn(number, 3, 3, generator=generator, dtype=torch.float64)).Q
    return basis * torch.linalg.det(basis)[:, None, None]


def seen_points(boxes: Boxes, number: int, generator: torch.Generator, noise_m: float = 0.0) -> Tensor:
    """Points (N, number, 3) on the faces that the camera sees, more on those that appear larger.

    Args:
        noise_m: standard deviation along the ray at one metre; it grows with the square of the distance.
    """
    away = boxes.face_centers()
    area = 8 * boxes.volume()[:, None] / boxes.half_extent.repeat_interleave(2, dim=1)
    apparent = area * -(away * boxes.face_normals()).sum(dim=-1) / away.norm(dim=-1) ** 3
    face = torch.multinomial(apparent * visible_faces(boxes), number, True, generator=generator)
    place = 2 * torch.rand(len(boxes), number, 3, generator=generator, dtype=torch.float64) - 1
    points = on_faces(boxes, face, place)
    step = noise_m * torch.randn(len(boxes), number, 1, generator=generator, dtype=torch.float64)
    return points + points * points.norm(dim=-1, keepdim=True) * step


def on_faces(boxes: Boxes, face: Tensor, place: Tensor) -> Tensor:
    """Points (N, P, 3) on the faces (N, P), at `place` (N, P, 3) in half extents from the middle."""
    side = torch.where(face % 2 == 0, 1.0, -1.0).to(place.dtype)
    place = place.scatter(2, (face // 2)[..., None], side[..., None])
    return boxes.center[:, None] + (place * boxes.half_extent[:, None]) @ boxes.rotation.transpose(1, 2)


def fitted(points: Tensor, fitter: BoxFitter | None = None, axis: Tensor | None = None) -> Fits:
    """Fit to all points (N, P, 3), set k with seed k; by minimum surface distance if not told otherwise."""
    n = len(points)
    return (fitter or MinimumSurface())(points, torch.full((n,), points.shape[1]), torch.arange(n), axis)


def tensors(fits: Fits) -> list[Tensor]:
    """All that fits hold."""
    boxes = fits.boxes
    return [boxes.center, boxes.rotation, boxes.half_extent, fits.mean, fits.variance, fits.visible_share]


def axis_error_deg(found: Boxes, true: Boxes) -> Tensor:
    """The largest angle between an axis and the one it stands for, (N,) degrees."""
    turn, _ = _matched(found, true)
    sine = torch.linalg.cross(turn.transpose(1, 2), true.rotation.transpose(1, 2)).norm(dim=-1)
    return torch.rad2deg(torch.asin(sine.clamp(max=1.0))).amax(dim=1)


def half_extent_error(found: Boxes, true: Boxes) -> Tensor:
    """(N, 3) metres by which half extents are too large, in the order of the true axes."""
    return _matched(found, true)[1] - true.half_extent


def _matched(found: Boxes, true: Boxes) -> tuple[Tensor, Tensor]:
    """Axes and half extents of the found boxes in the order of the true axes that they are nearest to."""
    likeness = (found.rotation.transpose(1, 2) @ true.rotation).abs()  # found axis, true axis
    fit = torch.stack([likeness[:, order, torch.arange(3)].sum(dim=1) for order in _ORDERS], dim=1)
    order = _ORDERS[fit.argmax(dim=1)]
    return found.rotation.gather(2, order[:, None].expand(-1, 3, -1)), found.half_extent.gather(1, order)
