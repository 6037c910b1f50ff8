"""Labels of planes made whole: a majority filter, and growth along a plane."""

from __future__ import annotations

from collections import Counter

import pytest
import torch
from torch import Tensor

from blockstab.rgbd.cloud import Cloud
from blockstab.segments.plane_labels import grown, majority, nearest_plane, smoothed

REACH = 0.01


def flat(heights: Tensor) -> Cloud:
    """Pixels 1 mm apart, all facing +z, each at its own z."""
    rows, columns = heights.shape
    v, u = torch.meshgrid(torch.arange(rows).double(), torch.arange(columns).double(), indexing="ij")
    normals = torch.zeros(rows, columns, 3, dtype=torch.float64)
    normals[..., 2] = 1.0
    valid = torch.isfinite(heights)
    points = torch.where(valid[..., None], torch.stack([u / 1000, v / 1000, heights], dim=2), 0.0)
    return Cloud(points, normals, valid, valid.double())


def level(*heights: float) -> Tensor:
    """(P, 4) planes z = height."""
    return torch.tensor([[0.0, 0.0, 1.0, -z] for z in heights], dtype=torch.float64)


def reach_of(cloud: Cloud) -> Tensor:
    return torch.where(cloud.valid, REACH, 0.0).double()


def test_a_pixel_takes_the_nearest_plane_within_reach() -> None:
    cloud = flat(torch.tensor([[0.0, 0.004, 0.006, 0.009, 0.0201, torch.nan]], dtype=torch.float64))
    assert nearest_plane(cloud, reach_of(cloud), level(0.0, 0.01), 0.1).tolist() == [[1, 1, 2, 2, 0, 0]]


def test_a_pixel_that_faces_elsewhere_is_on_no_plane() -> None:
    cloud = flat(torch.zeros(1, 3, dtype=torch.float64))
    cloud.normals[0, 1] = torch.tensor([0.6, 0.0, 0.8])
    cloud.normals[0, 2] = 0.0
    assert nearest_plane(cloud, reach_of(cloud), level(0.0), 0.1).tolist() == [[1, 0, 0]]


def test_the_majority_agrees_with_a_count_pixel_by_pixel(generator: torch.Generator) -> None:
    coarse = torch.randint(0, 4, (5, 6), generator=generator)
    label = coarse.repeat_interleave(6, dim=0).repeat_interleave(6, dim=1)
    noisy = torch.rand(label.shape, generator=generator) < 0.3
    label = torch.where(noisy, torch.randint(0, 4, label.shape, generator=generator), label)
    measured = torch.rand(label.shape, generator=generator) > 0.2
    expected = label.clone()
    for row in range(label.shape[0]):
        for column in range(label.shape[1]):
            window = (slice(max(row - 2, 0), row + 3), slice(max(column - 2, 0), column + 3))
            around = label[window][measured[window]].tolist()
            value, count = Counter(around).most_common(1)[0]
            if measured[row, column] and 2 * count > len(around):
                expected[row, column] = value
    found = majority(label, measured)
    assert torch.equal(found[measured], expected[measured])
    assert not torch.equal(found, label)


def test_the_majority_moves_no_pixel_to_a_plane_out_of_its_reach() -> None:
    heights = torch.zeros(9, 9, dtype=torch.float64)
    heights[2, 2], heights[2, 6], heights[6, 2], heights[6, 6] = 0.5, 0.02, 0.02, 0.004
    cloud = flat(heights)
    cloud.normals[2, 6] = cloud.normals[6, 6] = torch.tensor([0.6, 0.0, 0.8], dtype=torch.float64)
    label = nearest_plane(cloud, reach_of(cloud), level(0.0), 0.1)
    assert int((label == 0).sum()) == 4
    found = smoothed(label, cloud, reach_of(cloud), level(0.0), 0.1)
    # Too far; far, and turned away; as far, but not turned; and near, though turned.
    assert [int(found[at]) for at in ((2, 2), (2, 6), (6, 2), (6, 6))] == [0, 0, 1, 1]


def test_labels_grow_five_pixels_along_their_plane() -> None:
    heights = torch.zeros(3, 20, dtype=torch.float64)
    heights[:, 4] = 0.02
    cloud = flat(heights)
    label = torch.zeros(3, 20, dtype=torch.int64)
    label[:, :2], label[:, 10] = 1, 2
    found = grown(label, cloud, reach_of(cloud), level(0.0, 0.002))
    assert found[1].tolist() == [1] * 4 + [0] + [2] * 11 + [0] * 4
    assert not label[1, 2]


def test_where_two_planes_meet_a_pixel_goes_to_the_nearer_one() -> None:
    heights = torch.tensor([[0.0, 0.0, 0.008, 0.009, 0.009]], dtype=torch.float64)
    cloud = flat(heights)
    label = torch.tensor([[1, 1, 0, 2, 2]])
    assert grown(label, cloud, reach_of(cloud), level(0.0, 0.009)).tolist() == [[1, 1, 2, 2, 2]]


@pytest.mark.parametrize("size", [(1, 1), (2, 7)])
def test_small_images_are_filtered_too(size: tuple[int, int]) -> None:
    cloud, plane = flat(torch.zeros(size, dtype=torch.float64)), level(0.0)
    reach = reach_of(cloud)
    label = smoothed(nearest_plane(cloud, reach, plane, 0.1), cloud, reach, plane, 0.1)
    assert bool((grown(label, cloud, reach, plane) == 1).all())
