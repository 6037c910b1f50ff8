"""Plane labels of pixels, when the planes are known."""

from __future__ import annotations

import numpy as np
import torch
import torch.nn.functional as F
from torch import Tensor

from blockstab.rgbd.cloud import Cloud

_MAJORITY_PX = 5  # side of a window
_NOISE_REACHES = 3.0
_EDGE_PX = 5  # half the width of the windows that normals come from: nearer to an edge they may span it


def nearest_plane(cloud: Cloud, reach: Tensor, planes: Tensor, tilt: float) -> Tensor:
    """(H, W) int64: of planes within reach and with the pixel's normal, the nearest, from 1; 0 where there is none.

    Args:
        cloud: the image.
        reach: (H, W) float64, metres.
        planes: (P, 4) float64 unit normals and offsets, metres.
        tilt: one less the cosine of the angle that normals may differ by.
    """
    scale = torch.where(cloud.valid, 1.0 / reach, torch.inf)
    x, y, z = (cloud.points[..., k].mul(scale).float() for k in range(3))
    nx, ny, nz = (cloud.normals[..., k].float() for k in range(3))
    scale, best = scale.float(), torch.ones_like(scale, dtype=torch.float32)
    label = torch.zeros_like(best, dtype=torch.int16)
    for number, (a, b, c, d) in enumerate(planes.tolist(), start=1):
        off = (a * x).add_(y, alpha=b).add_(z, alpha=c).add_(scale, alpha=d).abs_()
        cosine = (a * nx).add_(ny, alpha=b).add_(nz, alpha=c)
        nearer = (off < best).logical_and_(cosine > 1.0 - tilt)
        best = torch.where(nearer, off, best)
        label.masked_fill_(nearer, number)
    return label.to(torch.int64)


def smoothed(label: Tensor, cloud: Cloud, reach: Tensor, planes: Tensor, tilt: float) -> Tensor:
    """The (H, W) int64 labels after a 5 x 5 majority filter, which moves no pixel to a plane out of its reach.

    Noise throws single pixels off: those whose normal, found in a window, still agrees reach three times as far.
    """
    result = majority(label, cloud.valid)
    rows, columns = ((result != label) & (result > 0)).nonzero().T
    plane = planes[result[rows, columns] - 1]
    agrees = (cloud.normals[rows, columns] * plane[:, :3]).sum(dim=1) > 1.0 - tilt
    off = _off(cloud.points[rows, columns], plane) / reach[rows, columns]
    near = off < torch.where(agrees, _NOISE_REACHES, 1.0)
    result[rows, columns] = torch.where(near, result[rows, columns], label[rows, columns])
    return result


def majority(label: Tensor, measured: Tensor) -> Tensor:
    """The (H, W) int64 labels; where more than half of the measured pixels around have one, that one."""
    half = _MAJORITY_PX // 2
    shown = torch.where(measured, label, -1)
    mixed = F.max_pool2d(_uneven(shown).float()[None], _MAJORITY_PX, stride=1, padding=half)[0] > 0
    rows, columns = (measured & mixed).nonzero().T
    padded = F.pad(shown, (half,) * 4, value=-1).to(torch.int16).numpy()
    windows = np.lib.stride_tricks.sliding_window_view(padded, (_MAJORITY_PX, _MAJORITY_PX))
    around = np.sort(windows[rows.numpy(), columns.numpy()].reshape(-1, _MAJORITY_PX**2), axis=1)
    # What more than half of them are is the middle one of those measured, which come last.
    count = (around >= 0).sum(axis=1, keepdims=True)
    middle = np.take_along_axis(around, around.shape[1] - (count + 1) // 2, axis=1)
    most = torch.from_numpy(2 * (around == middle).sum(axis=1) > count[:, 0])
    result = label.clone()
    result[rows, columns] = torch.where(most, torch.from_numpy(middle[:, 0]).long(), label[rows, columns])
    return result


def _uneven(label: Tensor) -> Tensor:
    """(H, W) bool: pixels whose right or lower neighbour has another label."""
    uneven = torch.zeros_like(label, dtype=torch.bool)
    uneven[:, :-1] |= label[:, :-1] != label[:, 1:]
    uneven[:-1] |= label[:-1] != label[1:]
    return uneven


def grown(label: Tensor, cloud: Cloud, reach: Tensor, planes: Tensor) -> Tensor:
    """The (H, W) int64 labels, grown along their planes over pixels next to edges, where normals mean little."""
    width = label.shape[1] + 2
    at = ((label == 0) & cloud.valid).nonzero()
    place = (at[:, 0] + 1) * width + at[:, 1] + 1
    points, reach = cloud.points[at[:, 0], at[:, 1]], reach[at[:, 0], at[:, 1]]
    steps, plane_of = place.new_tensor([-width, -1, 1, width]), F.pad(planes, (0, 0, 1, 0))
    shown = F.pad(label, (1, 1, 1, 1)).flatten()
    for _ in range(_EDGE_PX):
        beside = shown[place[:, None] + steps]
        front = ((beside > 0).any(dim=1) & (shown[place] == 0)).nonzero()[:, 0]
        beside = beside[front]
        off = _off(points[front, None], plane_of[beside]) / reach[front, None]
        off, nearest = torch.where(beside > 0, off, torch.inf).min(dim=1)
        shown[place[front]] = torch.where(off < 1.0, beside.gather(1, nearest[:, None])[:, 0], 0)
    return shown.view(-1, width)[1:-1, 1:-1].contiguous()


def _off(points: Tensor, planes: Tensor) -> Tensor:
    """Distances of points (..., 3) to planes (..., 4), metres."""
    return ((planes[..., :3] * points).sum(dim=-1) + planes[..., 3]).abs()
