"""Where boxes hold each other up, projected on the ground: against GEOS, and by hand."""

from __future__ import annotations

import math

import pytest
import shapely
import torch
from torch import Tensor

from blockstab.boxes.box import Boxes
from blockstab.geometry.convex_hulls import Polygons, area
from blockstab.stability.area import footprints, lowest_corners, on_ground, surface_areas, touching_edges
from blockstab.testing import worlds
from blockstab.testing.worlds import Block, build
from tests.seen_boxes import random_turns
from tests.tolerance import EXACT

FIRST, SECOND = torch.tensor([0]), torch.tensor([1])


def vertices(polygons: Polygons, which: int = 0) -> Tensor:
    return polygons.vertices[which, : int(polygons.count[which])]


def has_corners(polygons: Polygons, expected: list[list[float]], which: int = 0) -> bool:
    """Whether these are the vertices, in whatever order."""
    wanted, found = torch.tensor(expected, dtype=torch.float64), vertices(polygons, which)
    if found.shape != wanted.shape:
        return False
    apart = torch.cdist(found, wanted)
    return bool((apart.amin(dim=0) < EXACT).all() and (apart.amin(dim=1) < EXACT).all())


@pytest.fixture
def clutter(generator: torch.Generator) -> Boxes:
    """Boxes turned at random, many of whose footprints overlap."""
    return Boxes(
        0.3 * torch.randn(60, 3, generator=generator, dtype=torch.float64),
        random_turns(60, generator),
        0.05 + 0.2 * torch.rand(60, 3, generator=generator, dtype=torch.float64),
    )


def shadow(box: Boxes) -> shapely.Polygon:
    return shapely.MultiPoint(box.corners()[0][:, [0, 2]].tolist()).convex_hull


def test_the_ground_is_spanned_by_x_and_z() -> None:
    assert on_ground(torch.tensor([[1.0, 2.0, 3.0]])).tolist() == [[1.0, 3.0]]


def test_a_footprint_is_the_hull_of_the_projected_corners(clutter: Boxes) -> None:
    shadows = footprints(clutter)
    for k in range(len(clutter)):
        ours, theirs = shapely.Polygon(vertices(shadows, k)), shadow(clutter[k : k + 1])
        assert ours.symmetric_difference(theirs).area < 1e-12
    assert area(shadows).tolist() == pytest.approx(
        [shadow(clutter[k : k + 1]).area for k in range(len(clutter))], abs=1e-12
    )


def test_a_surface_area_is_where_both_footprints_overlap(clutter: Boxes) -> None:
    first, second = torch.triu_indices(60, 60, 1)
    overlap = area(surface_areas(footprints(clutter), first, second))
    shadows = [shadow(clutter[k : k + 1]) for k in range(60)]
    expected = [shadows[a].intersection(shadows[b]).area for a, b in zip(first, second, strict=True)]
    assert float((overlap - torch.tensor(expected, dtype=torch.float64)).abs().max()) < 1e-12
    assert 0.1 < float((overlap > 0).double().mean()) < 0.95


def test_the_area_of_an_overhanging_block_is_the_part_below_it() -> None:
    boxes, _ = build(*worlds.overhang(-0.05))
    found = surface_areas(footprints(boxes), FIRST, SECOND)
    assert has_corners(found, [[-0.05, -0.05], [-0.05, 0.05], [0.1, -0.05], [0.1, 0.05]])


def test_blocks_whose_footprints_only_touch_share_an_edge_without_area() -> None:
    boxes, _ = build(Block(0, 0, 0.2, 0.1), Block(0.2, 0.1, 0.2, 0.1))
    found = surface_areas(footprints(boxes), FIRST, SECOND)
    assert int(found.count[0]) == 2
    assert has_corners(found, [[0.1, -0.05], [0.1, 0.05]])


def test_a_plank_touches_the_wall_it_leans_on_with_its_upper_edge() -> None:
    boxes, _ = build(*worlds.LEANING_PLANK)
    found = touching_edges(boxes, SECOND, FIRST)
    upper = -0.015 - 0.6 * math.sin(math.radians(25.0))
    assert has_corners(found, [[upper, -0.05], [upper, 0.05]])


@pytest.mark.parametrize("gap", [0.0, 0.01, -0.01])  # in contact, almost touching, sunk in
def test_the_edge_that_touches_is_the_nearest_of_the_supported_box(gap: float) -> None:
    boxes, _ = build(Block(0, 0, 0.6, 0.1, d=0.3), Block(0.05, 0.1 + gap, 0.2, 0.05, tilt_deg=30.0))
    found = touching_edges(boxes, FIRST, SECOND)
    # The lower edge on the left stays where it was before the tilt.
    assert has_corners(found, [[-0.05, -0.05], [-0.05, 0.05]])


@pytest.mark.parametrize(("tilt_deg", "x"), [(5.0, -0.05), (-5.0, 0.15)])
def test_of_two_edges_within_the_other_box_the_deeper_one_touches(tilt_deg: float, x: float) -> None:
    boxes, _ = build(Block(0, 0, 0.6, 0.1, d=0.3), Block(0.05, 0.06, 0.2, 0.15, tilt_deg=tilt_deg))
    assert has_corners(touching_edges(boxes, FIRST, SECOND), [[x, -0.05], [x, 0.05]])


def test_the_touching_edge_is_as_near_as_any_edge_of_the_box(clutter: Boxes) -> None:
    first, second = torch.triu_indices(20, 20, 1)
    apart = (clutter.center[first] - clutter.center[second]).norm(dim=1) > 0.9
    first, second = first[apart], second[apart]
    found = touching_edges(clutter, first, second)
    for k, (a, b) in enumerate(zip(first.tolist(), second.tolist(), strict=True)):
        edges = clutter.edges()[b].flatten(0, 1)
        local = (edges - clutter.center[a]) @ clutter.rotation[a]
        beyond = (local.abs() - clutter.half_extent[a]).clamp(min=0)
        distance = beyond.norm(dim=1).view(12, 2).mean(dim=1)
        ends = on_ground(edges.view(12, 2, 3)[distance.argmin()])
        assert has_corners(found, ends.tolist(), k)


def test_of_edges_that_are_as_near_the_same_one_touches_however_the_world_is_turned() -> None:
    boxes, _ = build(Block(0, 0, 0.1, 0.1), Block(0.1, 0, 0.1, 0.1))
    expected = vertices(touching_edges(boxes, FIRST, SECOND))
    for degrees in range(1, 360, 7):
        c, s = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
        turn = torch.tensor([[c, 0, s], [0, 1, 0], [-s, 0, c]], dtype=torch.float64)
        found = vertices(touching_edges(boxes.rotated(turn), FIRST, SECOND))
        around = found @ turn[[0, 2]][:, [0, 2]]
        assert (around - expected).abs().max() < EXACT


def test_an_edge_that_stands_upright_touches_in_a_point() -> None:
    quarter = math.radians(45)
    cos, sin = math.cos(quarter), math.sin(quarter)
    spin = torch.tensor([[cos, 0.0, sin], [0.0, 1.0, 0.0], [-sin, 0.0, cos]], dtype=torch.float64)
    boxes, _ = build(Block(0, 0, 0.1, 0.2), Block(0, 0, 0.1, 0.2))
    reach = 0.05 * math.sqrt(2)
    turned = Boxes(
        boxes.center + torch.tensor([[0.0, 0, 0], [0.05 + reach, 0, 0]], dtype=torch.float64),
        torch.stack([boxes.rotation[0], spin]),
        boxes.half_extent,
    )
    found = touching_edges(turned, FIRST, SECOND)
    assert has_corners(found, [[0.05, 0.0]])


@pytest.mark.parametrize(("tilt_deg", "amount"), [(0.0, 4), (25.0, 2)])
def test_a_box_stands_on_its_lowest_corners(tilt_deg: float, amount: int) -> None:
    boxes, _ = build(Block(0.1, 0, 0.2, 0.3, tilt_deg=tilt_deg))
    found = lowest_corners(boxes, torch.tensor([1e-6], dtype=torch.float64))
    right = [[0.2, -0.05], [0.2, 0.05]] if amount == 4 else []
    assert has_corners(found, [[0.0, -0.05], [0.0, 0.05], *right])


def test_a_box_tilted_two_ways_stands_on_one_corner(generator: torch.Generator) -> None:
    box = Boxes(
        torch.zeros(1, 3, dtype=torch.float64),
        random_turns(1, generator),
        torch.tensor([[0.1, 0.2, 0.3]], dtype=torch.float64),
    )
    found = lowest_corners(box, torch.tensor([1e-3], dtype=torch.float64))
    lowest = box.corners()[0, box.corners()[0, :, 1].argmin()]
    assert has_corners(found, [on_ground(lowest).tolist()])


def test_corners_within_the_reach_count_and_each_box_has_its_own(generator: torch.Generator) -> None:
    tilted = Block(0, 0, 0.2, 0.1, tilt_deg=5.0)  # its right corners are 17 mm up
    boxes, _ = build(tilted, tilted)
    found = lowest_corners(boxes, torch.tensor([0.01, 0.02], dtype=torch.float64))
    assert found.count.tolist() == [2, 4]
