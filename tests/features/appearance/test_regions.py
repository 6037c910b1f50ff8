"""Measurements of regions, against numbers worked out by hand and by other libraries."""

from __future__ import annotations

import math
from dataclasses import astuple, replace

import numpy as np
import pytest
import torch
from scipy.ndimage import distance_transform_edt
from shapely import MultiPoint
from skimage.color import rgb2hsv
from torch import Tensor

from blockstab.features.appearance.extents import (
    footprint_area,
    kept_samples,
    moment_planes,
    residuals,
    sample_planes,
)
from blockstab.features.appearance.interior import BORDER_PX, near_others, others_near
from blockstab.features.appearance.regions import Regions, describe_regions
from blockstab.features.appearance.views import to_room
from blockstab.observation import Observation
from blockstab.rgbd.cloud import Cloud
from tests.features.observed import HEIGHT, WIDTH, cells, cluttered, observed
from tests.tolerance import COMPANY, EXACT

HORIZONTAL, VERTICAL, WALL_1, WALL_2 = 3, 4, 5, 6  # columns of `Regions.facing`


def halves() -> Tensor:
    label = torch.ones(HEIGHT, WIDTH, dtype=torch.int64)
    label[:, WIDTH // 2 :] = 2
    return label


def plain(depth: Tensor | float = 1.0) -> Observation:
    """A grey wall at a metre, straight ahead."""
    size = (HEIGHT, WIDTH)
    wall = torch.tensor([0.0, 0.0, 1.0], dtype=torch.float64).expand(*size, 3)
    grey = torch.full((*size, 3), 100, dtype=torch.uint8)
    depth = torch.as_tensor(depth, dtype=torch.float64).expand(size)
    return observed(depth, wall, grey, torch.zeros(size, dtype=torch.int64), torch.zeros(4, *size).double())


def tensors(regions: Regions) -> list[Tensor]:
    flat: list[Tensor] = []
    for value in astuple(regions):
        flat += value if isinstance(value, tuple) else [value]
    return flat


def test_the_border_is_what_lies_within_four_pixels_of_another_region(generator: torch.Generator) -> None:
    label = cells(12, generator)
    expected = torch.zeros_like(label, dtype=torch.bool)
    for region in range(1, int(label.max()) + 1):
        inside = label == region
        expected |= inside & (torch.from_numpy(distance_transform_edt(inside.numpy())) <= BORDER_PX)
    assert torch.equal(near_others(label), expected)


def test_others_near_names_every_label_within_reach(generator: torch.Generator) -> None:
    label = cells(9, generator)
    pixel, other = others_near(label)
    for region in range(1, int(label.max()) + 1):
        away = torch.from_numpy(distance_transform_edt((label != region).numpy()))
        expected = ((away <= BORDER_PX) & (label != region)).flatten().nonzero()[:, 0]
        assert torch.equal(pixel[other == region], expected)


def test_the_image_border_is_no_border_of_a_region() -> None:
    near = near_others(halves())
    assert near.sum(dim=1).unique().tolist() == [2 * BORDER_PX]


def test_colors_are_those_of_interior_and_border(generator: torch.Generator) -> None:
    label = cells(5, generator)
    observation = cluttered(label, generator)
    regions = describe_regions(observation, label)
    value = torch.from_numpy(rgb2hsv(observation.frame.color.numpy())[..., 2])
    red, green, blue = (observation.frame.color.double() / 255).unbind(dim=-1)
    luma = 0.299 * red + 0.587 * green + 0.114 * blue
    for region in range(len(regions)):
        for part, chosen in enumerate((~near_others(label), near_others(label))):
            mask = chosen & (label == region + 1)
            assert float(regions.colors.mean[region, part, 0]) == pytest.approx(float(luma[mask].mean()))
            spread = float(luma[mask].std(correction=0))
            assert float(regions.colors.deviation[region, part, 0]) == pytest.approx(spread)
            spread = float(value[mask].std(correction=0))
            assert float(regions.colors.value_deviation[region, part]) == pytest.approx(spread)


def test_a_region_is_the_same_within_1e_9_whatever_surrounds_it(generator: torch.Generator) -> None:
    label = cells(8, generator)
    observation = cluttered(label, generator)
    others = torch.where(label == 3, 1, 2)
    alone, among = describe_regions(observation, others), describe_regions(observation, label)
    for one, same in zip(tensors(alone), tensors(among), strict=True):
        torch.testing.assert_close(one[0], same[2], rtol=COMPANY, atol=COMPANY)
    assert torch.equal(alone.shapes.samples[0], among.shapes.samples[2])


def test_samples_are_pixels_of_the_interior(generator: torch.Generator) -> None:
    label = cells(6, generator)
    observation = cluttered(label, generator)
    shapes = describe_regions(observation, label).shapes
    height = observation.cloud.points[..., 1]  # which turning to the room leaves
    for region in range(len(shapes.sampled)):
        inside = height[(label == region + 1) & ~near_others(label)]
        assert int(shapes.sampled[region]) == math.ceil(0.9 * min(100, len(inside)))
        drawn = shapes.samples[region, : int(shapes.sampled[region]), 1]
        assert bool(torch.isin(drawn, inside).all())
        assert len(drawn.unique()) == len(drawn)


def test_a_wall_straight_ahead_is_flat_and_faces_along_one_axis() -> None:
    regions = describe_regions(plain(), halves())
    assert float(regions.shapes.residual.max()) < EXACT
    assert regions.places.plane[:, 2].abs().tolist() == pytest.approx([1.0, 1.0])
    assert regions.facing[:, 0, VERTICAL].tolist() == [1.0, 1.0]
    assert regions.facing[:, 0, WALL_2].tolist() == [1.0, 1.0]
    assert regions.facing[:, 0, HORIZONTAL].tolist() == [0.0, 0.0]
    assert regions.share.tolist() == [0.5, 0.5]


def test_places_span_all_pixels() -> None:
    places = describe_regions(plain(2.0), halves()).places
    height = 2.0 * (HEIGHT - 1) / 2 / 80.0
    assert places.least[:, 1].tolist() == pytest.approx([-height, -height])
    assert places.greatest[:, 1].tolist() == pytest.approx([height, height])
    assert places.mean[:, 1].abs().max() < EXACT
    assert places.near.tolist() == [2.0, 2.0]


def test_a_region_without_depth_has_the_points_of_the_nearest_pixels() -> None:
    depth = torch.ones(HEIGHT, WIDTH, dtype=torch.float64)
    depth[:, WIDTH // 2 :] = 0.0
    regions = describe_regions(plain(depth), halves())
    beside = (WIDTH // 2 - 1 - (WIDTH - 1) / 2) / 80.0  # of the last column with depth
    assert regions.places.greatest[1].tolist() == pytest.approx(
        [beside, (HEIGHT - 1) / 2 / 80.0, -1.0], abs=0.02
    )
    assert all(bool(t.isfinite().all()) for t in tensors(regions))
    assert regions.facing[1].abs().sum() == 0.0


def test_a_picture_without_depth_has_finite_measurements() -> None:
    assert all(bool(t.isfinite().all()) for t in tensors(describe_regions(plain(0.0), halves())))


def test_a_picture_without_labels_has_no_regions() -> None:
    assert len(describe_regions(plain(), torch.zeros(HEIGHT, WIDTH, dtype=torch.int64))) == 0


@pytest.mark.parametrize("turn", [0.0, 20.0, 44.0, 70.0])
def test_the_room_is_turned_to_its_walls(turn: float) -> None:
    angle = math.radians(turn)
    one = torch.tensor([math.cos(angle), 0.0, math.sin(angle)], dtype=torch.float64)
    other = torch.tensor([-math.sin(angle), 0.0, math.cos(angle)], dtype=torch.float64)
    normals = torch.cat(
        [one.expand(300, 3), other.expand(200, 3), torch.eye(3).double()[[1]].expand(900, 3)]
    )[None]
    full = torch.ones(1, len(normals[0]), dtype=torch.bool)
    rotation = to_room(Cloud(normals, normals, full, full.double()))
    assert float(torch.linalg.det(rotation)) == pytest.approx(1.0)
    assert rotation[1].tolist() == [0.0, 1.0, 0.0]
    assert float((rotation @ one).abs().max()) > math.cos(math.radians(1.0))
    assert float((rotation @ other).abs().max()) > math.cos(math.radians(1.0))


def test_a_room_without_walls_is_not_turned() -> None:
    assert torch.equal(
        to_room(replace(plain().cloud, normals=torch.zeros(HEIGHT, WIDTH, 3).double())), torch.eye(3)
    )


def test_planes_are_those_of_a_singular_value_decomposition(generator: torch.Generator) -> None:
    points = torch.randn(4, 30, 3, dtype=torch.float64, generator=generator) * torch.tensor([1.0, 0.5, 0.02])
    points = points + torch.tensor([0.2, 0.1, 2.0])
    count = torch.full((4,), 30)
    homogeneous = torch.cat([points, torch.ones(4, 30, 1)], dim=2)
    moments = homogeneous.mT @ homogeneous / 30
    for k in range(4):
        normal = np.linalg.svd((points[k] - points[k].mean(dim=0)).numpy())[2][-1]
        assert abs(float(sample_planes(points, count)[k, :3] @ torch.from_numpy(normal))) == pytest.approx(
            1.0
        )
        plane = np.linalg.svd(homogeneous[k].numpy())[2][-1]
        expected = torch.from_numpy(plane / np.linalg.norm(plane[:3]))
        assert moment_planes(moments)[k].abs().tolist() == pytest.approx(expected.abs().tolist(), abs=1e-6)


def test_a_single_point_lies_on_a_plane_that_faces_the_camera() -> None:
    point = torch.tensor([[[0.3, -0.2, -1.5]]], dtype=torch.float64)
    plane = sample_planes(point, torch.tensor([1]))[0]
    assert abs(float(plane[:3] @ point[0, 0])) == pytest.approx(float(point.norm()))


def test_a_footprint_is_the_same_within_1e_9_in_whatever_company(generator: torch.Generator) -> None:
    points = torch.randn(200, 20, 3, dtype=torch.float64, generator=generator)
    count = torch.full((200,), 20)
    together = footprint_area(points, count)
    for k in range(200):
        alone = footprint_area(points[k : k + 1], count[:1])[0]
        assert float(alone) == pytest.approx(float(together[k]), rel=COMPANY, abs=COMPANY)


@pytest.mark.parametrize(("width", "sampled"), [(10, 81), (11, 3)])
def test_a_region_with_fewer_than_three_pixels_of_interior_is_sampled_everywhere(
    width: int, sampled: int
) -> None:
    label = torch.ones(HEIGHT, WIDTH, dtype=torch.int64)
    label[20:29, 20 : 20 + width] = 2  # of which all but 2 or 3 pixels are border
    shapes = describe_regions(plain(), label).shapes
    assert int(shapes.sampled[1]) == sampled


@pytest.mark.parametrize("count", [1, 2, 5, 8])
def test_residuals_leave_out_what_is_past_the_count(count: int, generator: torch.Generator) -> None:
    points = torch.randn(1, 8, 3, dtype=torch.float64, generator=generator)
    plane = torch.tensor([[0.0, 0.0, 1.0, 0.5]], dtype=torch.float64)
    away = (points[0, :count, 2] + 0.5).abs().numpy()
    expected = [away.mean(), np.median(away), away.max()]
    assert residuals(points, torch.tensor([count]), plane)[0].tolist() == pytest.approx(expected)


def test_the_farthest_tenth_of_the_samples_is_left_out() -> None:
    points = torch.zeros(1, 100, 3, dtype=torch.float64)
    points[0, :, 0] = torch.arange(100)
    kept, count = kept_samples(points, torch.tensor([100]), 0.9)
    assert int(count) == 90
    assert sorted(kept[0, :, 0].tolist()) == list(range(5, 95))


@pytest.mark.parametrize("turn", [0.0, 0.3, 1.1])
def test_the_footprint_of_a_rectangle_is_its_area(turn: float) -> None:
    x, z = torch.meshgrid(
        torch.linspace(-2, 2, 20).double(), torch.linspace(-0.5, 0.5, 10).double(), indexing="ij"
    )
    cos, sin = math.cos(turn), math.sin(turn)
    points = torch.stack([cos * x - sin * z, torch.rand_like(x), sin * x + cos * z], dim=-1).view(1, -1, 3)
    assert float(footprint_area(points, torch.tensor([200]))) == pytest.approx(4.0)


def test_footprints_are_little_larger_than_the_least_rectangle(generator: torch.Generator) -> None:
    points = torch.randn(20, 30, 3, dtype=torch.float64, generator=generator)
    count = torch.randint(5, 31, (20,), generator=generator)
    found = footprint_area(torch.where(torch.arange(30)[:, None] < count[:, None, None], points, 0.0), count)
    for k in range(20):
        least = MultiPoint(points[k, : count[k], [0, 2]].numpy()).minimum_rotated_rectangle.area
        assert least - EXACT <= float(found[k]) <= 1.2 * least


def test_labels_with_gaps_are_refused() -> None:
    with pytest.raises(ValueError, match="without gaps, but 2 is missing"):
        describe_regions(plain(), torch.where(halves() == 2, 3, 1))


def test_labels_of_another_size_are_refused() -> None:
    with pytest.raises(ValueError, match=r"size of the image, \(60, 80\), but they have \(60, 79\)"):
        describe_regions(plain(), halves()[:, 1:])
