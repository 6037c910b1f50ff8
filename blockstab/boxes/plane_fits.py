"""Planes among noisy points by RANSAC and least squares: the two principal surfaces of Algorithm 1."""

from __future__ import annotations

from typing import NamedTuple

import torch
from torch import Tensor

# A sample whose points coincide or lie on a line spans no plane; its zero normal would win every vote.
DEGENERATE = 1e-9
FLAT_SHARE, FLAT_POINTS = 0.05, 10  # fewer points than this off the first plane cannot carry a second one
REFINE_STEPS = 4
RIDGE = 1e-3  # of all that points say about a turn: what they do not determine is left as it is
BORDER_SHARE = 0.01  # of the points lie beyond a face, as far as one looks for those that lie on it
ON_FACE = 1.5  # tolerances within which a point lies on its face


class Plane(NamedTuple):
    """R planes for each of N point sets: `normal @ p = offset`.

    Args:
        normal: (N, R, 3) unit vectors.
        offset: (N, R) metres.
    """

    normal: Tensor
    offset: Tensor


def first_plane(points: Tensor, present: Tensor, count: Tensor, tolerance: Tensor, draws: Tensor) -> Plane:
    """Fit S1: the plane of most inliers among S samples, then least squares on those inliers, for each restart.

    Args:
        points, present, tolerance: (N, J, 3), (N, J), (N, J).
        count: (N,) how many points are present.
        draws: (N, R, S, 3) uniform numbers that choose the samples.
    """
    n, r, s, _ = draws.shape
    index = (draws * count[:, None, None, None]).long().reshape(n, -1)
    a, b, c = _take(points, index).view(n, r, s, 3, 3).unbind(dim=3)
    normal = torch.linalg.cross(b - a, c - a)
    length = normal.norm(dim=-1, keepdim=True)
    normal = normal / length.clamp(min=DEGENERATE)
    offset = (normal * a).sum(dim=-1)
    inside = _within(points, present, tolerance, normal.flatten(1, 2), offset.flatten(1, 2)).view(n, r, s, -1)
    votes = inside.sum(dim=-1).masked_fill(length[..., 0] < DEGENERATE, -1)
    chosen = votes.argmax(dim=2)
    weight = inside.gather(2, chosen[..., None, None].expand(-1, -1, 1, inside.shape[-1]))[:, :, 0]
    # Where every sample of a restart was degenerate, all points vote: the plane of least squares.
    hopeless = votes.amax(dim=2) < 0
    weight = torch.where(hopeless[..., None], present[:, None], weight).to(points.dtype)
    return _least_squares(points, weight)


def fixed_plane(
    points: Tensor, present: Tensor, count: Tensor, tolerance: Tensor, draws: Tensor, axis: Tensor
) -> Plane:
    """S1 with its normal given: only its offset is sampled (`draws`: (N, R, S); `axis`: (N, 3))."""
    n, r, s = draws.shape
    height = (points * axis[:, None]).sum(dim=-1)
    index = (draws * count[:, None, None]).long().reshape(n, -1)
    offset = height.gather(1, index)
    votes = ((height[:, None] - offset[..., None]).abs() < tolerance[:, None]) & present[:, None]
    best = votes.sum(dim=-1).view(n, r, s).argmax(dim=2)
    offset = offset.view(n, r, s).gather(2, best[..., None])[..., 0]
    return Plane(axis[:, None].expand(-1, r, -1), offset)


def perpendicular_plane(
    points: Tensor, present: Tensor, tolerance: Tensor, plane: Plane, draws: Tensor
) -> tuple[Tensor, Tensor]:
    """Fit S2, perpendicular to S1, to the points that S1 leaves over.

    Seen along S1, such a plane is a line: two points make a sample, and the line's normal is the plane's.

    Args:
        draws: (N, R, S, 2) uniform numbers that choose the samples.

    Returns:
        normals (N, R, 3), and flat (N, R): too few points are left over to carry a plane.
    """
    n, r, s, _ = draws.shape
    outside = present[:, None] & ~_within(points, present, tolerance, plane.normal, plane.offset)
    left = outside.sum(dim=-1)
    flat = left < (FLAT_SHARE * present.sum(dim=1)).clamp(min=FLAT_POINTS)[:, None]
    u, v = plane_basis(plane.normal)
    flat_map = torch.stack([u, v], dim=-1)  # (N, R, 3, 2)
    seen = points[:, None] @ flat_map  # (N, R, J, 2)
    rank = (draws.reshape(n, r, -1) * left[..., None]).long() + 1
    index = torch.searchsorted(outside.cumsum(dim=-1), rank).clamp(max=points.shape[1] - 1)
    a, b = seen.gather(2, index[..., None].expand(-1, -1, -1, 2)).view(n, r, s, 2, 2).unbind(dim=3)
    along = b - a
    length = along.norm(dim=-1, keepdim=True)
    across = torch.stack([-along[..., 1], along[..., 0]], dim=-1) / length.clamp(min=DEGENERATE)
    distance = (across @ seen.transpose(2, 3) - (across * a).sum(dim=-1, keepdim=True)).abs()
    inside = (distance < tolerance[:, None, None]) & outside[:, :, None]
    votes = inside.sum(dim=-1).masked_fill(length[..., 0] < DEGENERATE, -1)
    chosen = votes.argmax(dim=2)
    weight = inside.gather(2, chosen[..., None, None].expand(-1, -1, 1, inside.shape[-1]))[:, :, 0]
    side = _line_normal(seen, weight.to(points.dtype))
    normal = side[..., :1] * u + side[..., 1:] * v
    return normal, flat


def refine(
    rotation: Tensor, points: Tensor, present: Tensor, tolerance: Tensor, axis: Tensor | None
) -> Tensor:
    """Turn the three axes together so that the points lie on their faces in the sense of least squares.

    Each point belongs to the nearest of the faces found along each axis, if it is within the tolerance; the
    offsets of the faces are free. With `axis` given, only the turn about it is free. A turn that the
    points do not determine (one face only) is left as it is.

    Args:
        rotation: (N, 3, 3) columns are axes; points: (N, P, 3); tolerance: (N, P); axis: (N, 3) or None.
    """
    columns = points.transpose(1, 2).contiguous()  # (N, 3, P): along memory everything below is a sweep
    for _ in range(REFINE_STEPS):
        local = (points @ rotation).transpose(1, 2).contiguous()
        face, inside = _nearest_faces(local, present, tolerance)  # (N, P), (N, P)
        weight = inside.to(points.dtype)[:, None]
        on_face = (face[:, None] == torch.arange(6)[:, None]) * weight  # (N, 6, P)
        mass = on_face.sum(dim=2).clamp(min=1.0)
        mean = _totals(on_face, columns) / mass[..., None]  # (N, 6, 3)
        centred = columns - _of_each(mean.transpose(1, 2), face) * weight
        normal = _of_each(rotation, face // 2)
        residual = (normal * centred).sum(dim=1, keepdim=True)
        lever = torch.linalg.cross(normal, centred, dim=1) * weight
        if axis is not None:
            lever = (lever * axis[..., None]).sum(dim=1, keepdim=True) * axis[..., None]
        matrix = _totals(lever, lever)
        ridge = RIDGE * matrix.diagonal(dim1=1, dim2=2).sum(dim=1).clamp(min=1e-12)
        matrix = matrix + ridge[:, None, None] * torch.eye(3, dtype=points.dtype)
        turn = -torch.linalg.solve(matrix, (lever * residual).transpose(1, 2).contiguous().sum(dim=1))
        rotation = _turned(rotation, turn)
    return rotation


def _of_each(vectors: Tensor, index: Tensor) -> Tensor:
    """Of vectors (N, 3, K) the one that each point asks for by index (N, P), (N, 3, P)."""
    return vectors.gather(2, index[:, None].expand(-1, 3, -1))


def _nearest_faces(local: Tensor, present: Tensor, tolerance: Tensor) -> tuple[Tensor, Tensor]:
    """The face each point (N, 3, P) lies on, (N, P) in 0..5, and whether it does, (N, P)."""
    low = _robust_border(local, present)
    high = -_robust_border(-local, present)
    distance = torch.stack([(high - local).abs(), (local - low).abs()], dim=2).flatten(1, 2)
    nearest = distance.min(dim=1)
    return nearest.indices, (nearest.values < ON_FACE * tolerance) & present


def _robust_border(values: Tensor, present: Tensor) -> Tensor:
    """The end of the lowest 1 % of each coordinate: (N, 3, P) to (N, 3, 1)."""
    rank = (BORDER_SHARE * present.sum(dim=1)).long()
    ordered = values.masked_fill(~present[:, None], float("inf"))
    lowest = ordered.topk(int(rank.max()) + 1, dim=2, largest=False).values
    return lowest.gather(2, rank[:, None, None].expand(-1, 3, 1))


def _turned(rotation: Tensor, turn: Tensor) -> Tensor:
    """Rotate the axes by the rotation vectors `turn` (N, 3), radians (Rodrigues 1840)."""
    angle = turn.square().sum(dim=1, keepdim=True).sqrt().clamp(min=1e-12)
    pole = (turn / angle)[..., None].expand_as(rotation)
    sine, cosine = torch.sin(angle)[..., None], torch.cos(angle)[..., None]
    along = pole * (pole * rotation).sum(dim=1, keepdim=True)
    turned: Tensor = (
        cosine * rotation + sine * torch.linalg.cross(pole, rotation, dim=1) + (1 - cosine) * along
    )
    return turned


def _within(points: Tensor, present: Tensor, tolerance: Tensor, normal: Tensor, offset: Tensor) -> Tensor:
    """Mask of the points on each plane, (N, K, J), for normals (N, K, 3) and offsets (N, K)."""
    distance = (normal @ points.transpose(1, 2) - offset[..., None]).abs()
    return (distance < tolerance[:, None]) & present[:, None]


def _least_squares(points: Tensor, weight: Tensor) -> Plane:
    """Planes of least squares for weights (N, R, J) on points (N, J, 3)."""
    mass = weight.sum(dim=-1).clamp(min=1.0)
    columns = points.transpose(1, 2).contiguous()
    products = columns[:, :, None] * columns[:, None]
    mean = _totals(weight, columns) / mass[..., None]
    second = _totals(weight, products.flatten(1, 2)).view(*mass.shape, 3, 3) / mass[..., None, None]
    covariance = second - mean[..., :, None] * mean[..., None, :]
    normal = torch.linalg.eigh(covariance).eigenvectors[..., 0]
    return Plane(normal, (normal * mean).sum(dim=-1))


def _totals(weight: Tensor, columns: Tensor) -> Tensor:
    """Sums (N, R, K) of columns (N, K, J) over J with weights (N, R, J)."""
    # A matrix product rounds by where in memory each set of the batch begins; a sum along memory does not.
    return torch.stack([(weight * columns[:, None, k]).sum(dim=-1) for k in range(columns.shape[1])], dim=-1)


def _line_normal(seen: Tensor, weight: Tensor) -> Tensor:
    """Unit normals of the least-squares lines through 2-D points (N, R, J, 2), (N, R, 2)."""
    mass = weight.sum(dim=-1).clamp(min=1.0)
    mean = (weight[..., None] * seen).sum(dim=2) / mass[..., None]
    x, y = ((seen - mean[:, :, None]) * weight[..., None]).unbind(dim=-1)
    wider, twice = (x * x).sum(dim=-1) - (y * y).sum(dim=-1), 2 * (x * y).sum(dim=-1)
    # The half angle without its arctangent, which torch rounds by the place of a number in the batch.
    size = (wider.square() + twice.square()).sqrt() + wider.abs()
    slope = twice / size.clamp(min=torch.finfo(seen.dtype).tiny)
    one = torch.ones_like(slope)
    steep = (wider < 0)[..., None]
    normal = torch.where(steep, torch.stack([-one, slope], dim=-1), torch.stack([-slope, one], dim=-1))
    return normal / (1 + slope.square()).sqrt()[..., None]


def plane_basis(normal: Tensor) -> tuple[Tensor, Tensor]:
    """Two unit vectors that span the plane of each normal (..., 3)."""
    helper = torch.zeros_like(normal)
    helper.scatter_(-1, normal.abs().argmin(dim=-1, keepdim=True), 1.0)
    u = torch.linalg.cross(normal, helper)
    u = u / u.norm(dim=-1, keepdim=True)
    return u, torch.linalg.cross(normal, u)


def _take(points: Tensor, index: Tensor) -> Tensor:
    """Points (N, J, 3) at indices (N, K): (N, K, 3)."""
    return points.gather(1, index[..., None].expand(-1, -1, 3))
