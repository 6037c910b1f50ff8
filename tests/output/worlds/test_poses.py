"""Quaternions and angles turn as the rotations do that they were made of."""

from __future__ import annotations

import math

import pytest
import torch

from blockstab.boxes.box import rotation_of
from blockstab.output.worlds.poses import fixed_angles, numbers, on_z_plane, quaternion_of
from blockstab.testing.worlds import Block
from tests.output.worlds.arrangements import arranged


def about(axis: int, angle: float) -> torch.Tensor:
    turn = torch.eye(3, dtype=torch.float64)
    a, b = (k for k in range(3) if k != axis)
    sign = -1.0 if axis == 1 else 1.0
    turn[a, a] = turn[b, b] = math.cos(angle)
    turn[a, b], turn[b, a] = -sign * math.sin(angle), sign * math.sin(angle)
    return turn


@pytest.mark.parametrize("trial", range(20))
def test_a_rotation_comes_back(trial, generator):
    rotation = rotation_of(torch.randn(4, generator=generator, dtype=torch.float64))
    quaternion = torch.tensor(quaternion_of(rotation), dtype=torch.float64)
    assert float(quaternion.norm()) == pytest.approx(1.0)
    assert torch.allclose(rotation_of(quaternion), rotation, atol=1e-12)
    roll, pitch, yaw = fixed_angles(rotation)
    assert torch.allclose(about(2, yaw) @ about(1, pitch) @ about(0, roll), rotation, atol=1e-12)


@pytest.mark.parametrize("pitch", [math.pi / 2, -math.pi / 2])
def test_a_rotation_comes_back_where_two_angles_are_about_one_axis(pitch):
    rotation = about(2, 0.3) @ about(1, pitch) @ about(0, 0.2)
    roll, found, yaw = fixed_angles(rotation)
    assert torch.allclose(about(2, yaw) @ about(1, found) @ about(0, roll), rotation, atol=1e-9)


def test_what_stands_on_the_ground_stands_on_the_plane_of_z():
    boxes = on_z_plane(arranged(Block(0.3, 0, 0.1, 0.4, z=0.2), lifted=-1.5))
    assert float(boxes.corners()[0, :, 2].amin()) == pytest.approx(0.0, abs=1e-12)
    assert float(boxes.corners()[0, :, 2].amax()) == pytest.approx(0.4)
    assert boxes.center[0, :2].tolist() == pytest.approx([0.3, -0.2])


def test_numbers_are_written_as_xml_has_them():
    assert numbers((1.0, 0.25, -3.0)) == "1 0.25 -3"
