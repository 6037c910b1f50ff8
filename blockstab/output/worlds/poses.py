"""Poses as formats write them: z up, and rotations as quaternions or as angles about fixed axes."""

from __future__ import annotations

import math

import torch
from torch import Tensor

from blockstab.boxes.box import Boxes
from blockstab.stability.arrangement import Arrangement

_Z_UP = torch.tensor([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]], dtype=torch.float64)


def on_z_plane(asked: Arrangement) -> Boxes:
    """The boxes in a frame with +z up, the ground at z = 0."""
    boxes = asked.boxes.rotated(_Z_UP)
    up = torch.tensor([0.0, 0.0, asked.ground_height], dtype=torch.float64)
    return Boxes(boxes.center - up, boxes.rotation, boxes.half_extent)


def quaternion_of(rotation: Tensor) -> tuple[float, float, float, float]:
    """The unit quaternion (w, x, y, z), w not negative, of a rotation (3, 3)."""
    r = rotation.tolist()
    # The largest of the four is found first, for a quotient by it is exact.
    squares = [
        1 + r[0][0] + r[1][1] + r[2][2],
        1 + r[0][0] - r[1][1] - r[2][2],
        1 - r[0][0] + r[1][1] - r[2][2],
        1 - r[0][0] - r[1][1] + r[2][2],
    ]
    k = max(range(4), key=squares.__getitem__)
    products = (
        (squares[0], r[2][1] - r[1][2], r[0][2] - r[2][0], r[1][0] - r[0][1]),
        (r[2][1] - r[1][2], squares[1], r[0][1] + r[1][0], r[0][2] + r[2][0]),
        (r[0][2] - r[2][0], r[0][1] + r[1][0], squares[2], r[1][2] + r[2][1]),
        (r[1][0] - r[0][1], r[0][2] + r[2][0], r[1][2] + r[2][1], squares[3]),
    )[k]
    sign = -1.0 if products[0] < 0 else 1.0
    scale = sign / (2 * math.sqrt(squares[k]))
    w, x, y, z = (scale * part for part in products)
    return w, x, y, z


def fixed_angles(rotation: Tensor) -> tuple[float, float, float]:
    """Roll, pitch and yaw, radians: turns about the fixed axes x, y and z, in that order, that make a rotation."""
    r = rotation.tolist()
    pitch = math.atan2(-r[2][0], math.hypot(r[0][0], r[1][0]))
    if math.hypot(r[0][0], r[1][0]) < 1e-9:  # roll and yaw are about one axis
        return math.atan2(-r[1][2], r[1][1]), pitch, 0.0
    return math.atan2(r[2][1], r[2][2]), pitch, math.atan2(r[1][0], r[0][0])


def numbers(values: Tensor | tuple[float, ...]) -> str:
    """Numbers side by side, as XML has them."""
    listed = values.tolist() if isinstance(values, Tensor) else values
    return " ".join(f"{value:.9g}" for value in listed)
