"""The surface of segments, against sums over their pixels one segment at a time."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
import torch
from shapely import Polygon, box
from torch import Tensor

from blockstab.features.surface import SURFACE_COLUMNS, Surfaces
from blockstab.observation import Observation
from blockstab.segments.atoms import Atoms, make_atoms
from tests.features.atoms_scene import clutter, grouped, renamed
from tests.features.pixel_loop import sides
from tests.tolerance import COMPANY, EXACT

Made = tuple[Observation, Atoms, list[frozenset[int]]]


@cache
def made(seed: int = 7) -> Made:
    """An image over a known ground, in atoms; groups of atoms near and far, single ones, and all."""
    generator = torch.Generator().manual_seed(seed)
    observation, atoms = clutter(generator, unlabelled=True)
    height = float(observation.cloud.points[..., 1].quantile(0.3))
    observation = replace(observation, ground=replace(observation.ground, height=height))
    some = list(grouped(atoms, generator).segments)
    return observation, atoms, [*some, frozenset({0}), frozenset({3}), frozenset(range(len(atoms)))]


def measured(observation: Observation, atoms: Atoms, segments: list[frozenset[int]]) -> Tensor:
    return Surfaces(observation, atoms)(segments)


def ycbcr(rgb: np.ndarray) -> np.ndarray:
    """Luma, and how far blue and red are from it (ITU-R BT.601, as JPEG scales it)."""
    luma = rgb @ np.array([0.299, 0.587, 0.114])
    return np.stack([luma, 0.564 * (rgb[..., 2] - luma) + 0.5, 0.713 * (rgb[..., 0] - luma) + 0.5], axis=-1)


def by_pixels(observation: Observation, atoms: Atoms, segment: frozenset[int]) -> dict[str, float]:
    """All columns of one segment, worked out the slow way."""
    label = atoms.label.numpy()
    mask = np.isin(label - 1, list(segment))
    pixels, valid = int(mask.sum()), (observation.cloud.valid.numpy() & mask)
    depth, camera = observation.cloud.depth.numpy(), observation.frame.camera
    colors = ycbcr(observation.frame.color.numpy() / 255.0)
    planes = observation.planes.label.numpy()
    shares = [np.sum(planes[mask] == plane) / pixels for plane in range(1, planes.max() + 1)]
    normals = observation.cloud.normals.numpy()[mask]
    facing = normals.sum(axis=0) / max(np.any(normals != 0, axis=1).sum(), 1)
    height = observation.cloud.points.numpy()[..., 1][valid] - observation.ground.height
    rows, columns = np.nonzero(mask)
    spread = np.cov(np.stack([columns, rows]), bias=True) + np.eye(2) / 12 if pixels > 1 else np.eye(2) / 12
    short, long = np.sqrt(np.linalg.eigvalsh(spread))
    return {
        "pixels_log": math.log(pixels),
        "area_log": math.log(max((depth[mask] ** 2).sum() / (camera.fx * camera.fy), 1e-9)),
        "measured_share": valid.sum() / pixels,
        "ground_share": observation.on_ground.numpy()[mask].mean(),
        "plane_share": max(shares),
        "plane_count": sum(share > 0.1 for share in shares),
        **_named("deviation", colors[mask].std(axis=0)),
        **_named("contrast", np.abs(colors[mask].mean(axis=0) - _around(label, colors, segment))),
        "facing_length": float(np.linalg.norm(facing)),
        "facing_up": facing[1],
        "height_mean": height.mean(),
        "height_deviation": height.std(),
        "height_least": height.min(),
        "height_greatest": height.max(),
        "distance": depth[valid].mean(),
        "elongation": short / long,
        "fill_of_hull": pixels / touched(rows, columns).area,
        "fill_of_ellipse": pixels / max(4 * math.pi * short * long, 1.0),
    }


def _named(what: str, values: np.ndarray) -> dict[str, float]:
    return {f"{what}_{color}": value for color, value in zip(("luma", "blue", "red"), values, strict=True)}


def _around(label: np.ndarray, colors: np.ndarray, segment: frozenset[int]) -> np.ndarray:
    """The mean colour of the atoms beside a segment, each as often as sides of its pixels touch it."""
    beside = []
    for one, other in sides(torch.from_numpy(label)):
        a, b = label[one] - 1, label[other] - 1
        if a >= 0 and b >= 0 and (a in segment) != (b in segment):
            beside.append(colors[label == (b if a in segment else a) + 1].mean(axis=0))
    return np.mean(beside, axis=0) if beside else colors[np.isin(label - 1, list(segment))].mean(axis=0)


def touched(rows: np.ndarray, columns: np.ndarray) -> Polygon:
    """The polygon of 16 lines that touch a set of pixels, each a unit square."""
    corners = np.concatenate(
        [np.stack([columns + x, rows + y], axis=1) for x in (-0.5, 0.5) for y in (-0.5, 0.5)]
    )
    shape = box(-500, -500, 500, 500)
    for k in range(16):
        unit = np.array([math.cos(k * math.pi / 8), math.sin(k * math.pi / 8)])
        across, reach = np.array([-unit[1], unit[0]]), (corners @ unit).max()
        half = [
            reach * unit + s * 2000 * across - t * 2000 * unit for s, t in ((-1, 0), (1, 0), (1, 1), (-1, 1))
        ]
        shape = shape.intersection(Polygon(half))
    return shape


@pytest.mark.parametrize("seed", [7, 8])
def test_every_column_is_what_sums_over_the_pixels_of_a_segment_give(seed):
    observation, atoms, segments = made(seed)
    for segment, row in zip(segments, measured(observation, atoms, segments), strict=True):
        expected = by_pixels(observation, atoms, segment)
        assert list(expected) == list(SURFACE_COLUMNS)
        assert dict(zip(SURFACE_COLUMNS, row.tolist(), strict=True)) == pytest.approx(expected, abs=1e-6)


def test_the_images_have_all_that_is_to_be_measured():
    observation, atoms, segments = made()
    rows = measured(observation, atoms, segments)
    assert [n for n, column in zip(SURFACE_COLUMNS, rows.T, strict=True) if float(column.std()) == 0] == []


def test_a_segment_is_the_same_within_1e_9_in_whatever_company_it_is_measured():
    observation, atoms, segments = made()
    surfaces = Surfaces(observation, atoms)
    alone = torch.cat([surfaces([segment]) for segment in segments])
    torch.testing.assert_close(surfaces(segments * 20), alone.repeat(20, 1), rtol=0.0, atol=COMPANY)


def test_the_names_of_atoms_do_not_matter(generator):
    observation, atoms, segments = made()
    under_other_names = measured(observation, *renamed(observation, atoms, segments, generator))
    torch.testing.assert_close(
        under_other_names, measured(observation, atoms, segments), rtol=0.0, atol=COMPANY
    )


def test_turning_the_world_about_the_vertical_changes_nothing():
    observation, atoms, segments = made()
    cos, sin = math.cos(0.7), math.sin(0.7)
    turn = torch.tensor([[cos, 0.0, sin], [0.0, 1.0, 0.0], [-sin, 0.0, cos]], dtype=torch.float64)
    ground = replace(observation.ground, world_from_camera=turn @ observation.ground.world_from_camera)
    turned = replace(observation, cloud=observation.cloud.rotated(turn), ground=ground)
    torch.testing.assert_close(
        measured(turned, atoms, segments), measured(observation, atoms, segments), rtol=0.0, atol=EXACT
    )


def test_a_rectangle_fills_its_hull_and_a_single_pixel_is_no_worse_a_square():
    observation, _, _ = made()
    label = torch.ones_like(made()[1].label)
    label[10:20, 30:60] = 2
    label[40, 40] = 3
    atoms = make_atoms(label, observation.boundary_map.strength)
    rows = measured(observation, atoms, [frozenset({1}), frozenset({2})])
    named = [dict(zip(SURFACE_COLUMNS, row.tolist(), strict=True)) for row in rows]
    assert named[0]["fill_of_hull"] == pytest.approx(1.0)
    assert named[0]["elongation"] == pytest.approx(1 / 3)
    assert named[0]["fill_of_ellipse"] == pytest.approx(3 / math.pi)
    assert named[1]["elongation"] == pytest.approx(1.0)


def test_what_has_no_depth_has_height_and_distance_0():
    observation, atoms, _ = made()
    hole = atoms.label == 1
    cloud = replace(
        observation.cloud,
        valid=observation.cloud.valid & ~hole,
        depth=torch.where(hole, 0.0, observation.cloud.depth),
        normals=torch.where(hole[..., None], 0.0, observation.cloud.normals),
    )
    (row,) = measured(replace(observation, cloud=cloud), atoms, [frozenset({0})])
    values = dict(zip(SURFACE_COLUMNS, row.tolist(), strict=True))
    nothing = ("measured_share", "facing_length", "distance", *(n for n in values if n.startswith("height")))
    assert {values[name] for name in nothing} == {0.0}
    assert bool(row.isfinite().all())


def test_without_planes_none_is_counted():
    observation, atoms, segments = made()
    bare = replace(
        observation, planes=type(observation.planes)(label=torch.zeros_like(observation.planes.label))
    )
    rows = measured(bare, atoms, segments)
    for name in ("plane_share", "plane_count"):
        assert not bool(rows[:, SURFACE_COLUMNS.index(name)].any())
