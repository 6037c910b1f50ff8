"""RANSAC planes and DBSCAN clusters of the other points, by Open3D: what one would try first."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import torch

from blockstab.observation import Observation
from blockstab.proposals import Proposed

_SAMPLE = 3  # points that a plane is laid through


@dataclass(frozen=True)
class PlaneDBSCAN:
    """RANSAC planes, then DBSCAN on a voxel grid; every pixel takes the cluster of its voxel.

    Args:
        planes: taken away one after the other, while they hold `least_share` of the points.
        inlier_m: distance to a plane.
        least_share: of all points.
        voxel_m: side of a voxel.
        reach_m, least_voxels: of DBSCAN: the radius, and how many voxels within it make a core.
        least_px: smaller clusters are no region.
    """

    planes: int = 3
    inlier_m: float = 0.01
    least_share: float = 0.1
    voxel_m: float = 0.005
    reach_m: float = 0.015
    least_voxels: int = 10
    least_px: int = 100

    def __call__(self, observation: Observation) -> Proposed:
        """Divide the image: id 1 is what the planes took, clusters follow."""
        import open3d

        valid = observation.cloud.valid
        points = observation.cloud.points[valid].numpy()
        label = np.zeros(len(points), dtype=np.int64)
        left = np.arange(len(points))
        open3d.utility.random.seed(0)
        for _ in range(self.planes):
            if len(left) < _SAMPLE:
                break
            cloud = open3d.geometry.PointCloud(open3d.utility.Vector3dVector(points[left]))
            _, inliers = cloud.segment_plane(self.inlier_m, ransac_n=_SAMPLE, num_iterations=300)
            if len(inliers) < self.least_share * len(points):
                break
            label[left[inliers]] = 1
            left = np.delete(left, inliers)
        if len(left):
            cell = np.floor(points[left] / self.voxel_m).astype(np.int64)
            cells, owner = np.unique(cell, axis=0, return_inverse=True)
            centers = open3d.utility.Vector3dVector((cells + 0.5) * self.voxel_m)
            clusters = np.asarray(
                open3d.geometry.PointCloud(centers).cluster_dbscan(self.reach_m, self.least_voxels)
            )
            label[left] = np.where(clusters >= 0, clusters + 2, 0)[owner.reshape(-1)]
        label[np.bincount(label)[label] < self.least_px] = 0
        image = torch.zeros(valid.shape, dtype=torch.int64)
        image[valid] = torch.from_numpy(label)
        return Proposed(image, {1: True} if (label == 1).any() else {})
