"""The planes of a simulated image of 640 x 480, beside Open3D's `segment_plane` called once for each of them.

Open3D takes one plane away after the other, and stops with a set of points for each. Ours ends with a label for every
pixel, after a majority filter and without small pieces.
"""

from __future__ import annotations

import numpy as np
import pytest
from pytest_benchmark.fixture import BenchmarkFixture

from blockstab.rgbd.cloud import Cloud, cloud_from_frame
from blockstab.segments.plane_map import find_planes

SEED, INLIER_M, ITERATIONS = 9200, 0.0075, 300

pytestmark = pytest.mark.benchmark(group="planes of an image of 640 x 480")


@pytest.fixture(scope="module")
def cloud() -> Cloud:
    pytest.importorskip("mujoco")
    from blockstab.simulation.simulated import Recipe, simulate_scene

    frame, _ = simulate_scene(Recipe("objects", SEED), 3)
    return cloud_from_frame(frame)


def test_find_planes(benchmark: BenchmarkFixture, cloud: Cloud) -> None:
    assert len(benchmark(find_planes, cloud).planes) > 3


def test_segment_plane_of_open3d(benchmark: BenchmarkFixture, cloud: Cloud) -> None:
    open3d = pytest.importorskip("open3d")
    points = open3d.geometry.PointCloud(open3d.utility.Vector3dVector(np.asarray(cloud.points[cloud.valid])))
    count = len(find_planes(cloud).planes)

    def planes() -> list[object]:
        open3d.utility.random.seed(0)
        left, found = points, []
        for _ in range(count):
            plane, inliers = left.segment_plane(INLIER_M, ransac_n=3, num_iterations=ITERATIONS)
            left = left.select_by_index(inliers, invert=True)
            found.append(plane)
        return found

    assert len(benchmark(planes)) == count
