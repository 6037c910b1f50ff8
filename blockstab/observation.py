"""Observation of an image, without object hypotheses: points, ground, boundaries, planes, atoms."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import torch
from torch import Tensor

from blockstab.boundaries import BoundaryMap
from blockstab.boundaries.cues import cues_of
from blockstab.boundaries.edge_models import EdgeModel, FixedWeights
from blockstab.boundaries.gradients import COLOR_GRADIENTS, pb
from blockstab.rgbd.cloud import Cloud, cloud_from_frame
from blockstab.rgbd.frame import Frame
from blockstab.rgbd.ground import Ground, estimate_ground, ground_from_up
from blockstab.segments.atoms import over_segment
from blockstab.segments.gaps import enclosed, flood_gaps
from blockstab.segments.plane_map import PlaneMap, find_planes
from blockstab.segments.shadows import shadows

_FIXED = FixedWeights()
_FLAT = 0.9  # cosine to up, of a normal that belongs to the ground
_FLAT_REACH = (0.01, 2.0)  # metres and sensor steps, the larger: how far from the ground such a pixel may lie
_EDGE = 0.3  # of colour: an edge in a gap that no part grows across
_REACH = (0.003, 1.0)  # and any other pixel, for at the foot of an object few normals are right


class GroundFinder(Protocol):
    """A named function from an image and its points to the ground."""

    @property
    def __name__(self) -> str: ...

    def __call__(self, frame: Frame, cloud: Cloud, /) -> Ground: ...


@dataclass(frozen=True)
class Observation:
    """An image, and all that is computed of it once, for proposals, features and searches alike.

    Args:
        frame: the image.
        cloud: its points, in the world frame.
        ground: the ground plane, and which way is up.
        boundary_map: how likely each pixel is to lie between two objects.
        cues: (8, H, W) float32 how strong each of `CUES` is, whichever way it runs.
        planes: its large planes.
        fine: (H, W) int64 the over-segmentation: 0 = none, parts from 1, each 4-connected.
    """

    frame: Frame
    cloud: Cloud
    ground: Ground
    boundary_map: BoundaryMap
    cues: Tensor
    planes: PlaneMap
    fine: Tensor

    @property
    def on_ground(self) -> Tensor:
        """(H, W) bool: measured pixels in the ground plane; none where its height is unknown."""
        if self.ground.height is None:
            return torch.zeros_like(self.cloud.valid)
        step = self.cloud.noise.at(self.cloud.depth**2)
        height = (self.cloud.points[..., 1] - self.ground.height).abs()
        flat = self.cloud.normals[..., 1] > _FLAT
        reach = torch.where(
            flat,
            (_FLAT_REACH[1] * step).clamp(min=_FLAT_REACH[0]),
            (_REACH[1] * step).clamp(min=_REACH[0]),
        )
        return self.cloud.valid & (height < reach)


def estimated_ground(frame: Frame, cloud: Cloud) -> Ground:
    """The ground as the image shows it."""
    return estimate_ground(cloud)


def given_ground(frame: Frame, cloud: Cloud) -> Ground:
    """The ground for the up direction that the scene's `meta.json` gives.

    Raises:
        ValueError: if it gives none.
    """
    if frame.up_camera is None:
        raise ValueError(f"{frame.name} has no `up_camera` in its meta.json; let it be estimated.")
    return ground_from_up(cloud, frame.up_camera)


def observe(frame: Frame, ground_of: GroundFinder, edges: EdgeModel = _FIXED) -> Observation:
    """Look at an image; `edges` weighs the cues of a boundary."""
    cloud = cloud_from_frame(frame)
    ground = ground_of(frame, cloud)
    return observation_of(frame, cloud.rotated(ground.world_from_camera), ground, edges)


def observation_of(frame: Frame, cloud: Cloud, ground: Ground, edges: EdgeModel = _FIXED) -> Observation:
    """The boundaries and parts of an image whose points, in the world frame, and ground are known.

    The shadow that a thing casts belongs to what is behind it. Other gaps in the depth are left by black, shiny and
    transparent things. There colour alone tells where things end, and the parts around a gap grow into it as far as
    their colour goes on; and then, across edges too, into what they enclose. So every part has measured pixels.
    """
    cues, planes = cues_of(frame), find_planes(cloud)
    found, shadow = edges(cues), shadows(cloud.depth, frame.camera.fx, cloud.noise.baseline_m)
    fine = over_segment(found.strength, cloud.valid, planes.label, shadow)
    gaps = ~cloud.valid & (fine == 0) & (shadow < 0)
    if bool(gaps.any()):
        oriented = torch.where(gaps, pb(cues.values[: len(COLOR_GRADIENTS)]).double(), found.oriented)
        found = BoundaryMap(oriented, oriented.amax(dim=0))
        fine = flood_gaps(fine, gaps & (found.strength < _EDGE), found.strength)
        fine = flood_gaps(fine, enclosed(gaps & (fine == 0)), found.strength)
    return Observation(frame, cloud, ground, found, cues.values.amax(dim=1), planes, fine)
