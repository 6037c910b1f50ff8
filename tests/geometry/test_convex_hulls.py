"""Convex polygons: by hand, in exact contact, turned, against Qhull, GEOS and integer arithmetic."""

from __future__ import annotations

import math
from fractions import Fraction
from itertools import pairwise

import pytest
import shapely
import torch
from scipy.spatial import ConvexHull
from torch import Tensor

from blockstab.geometry.convex_hulls import Polygons, area, centroid, clip, concatenate, hull, signed_distance
from tests.tolerance import EXACT

SQUARE = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]


def polygon(*corners: list[float]) -> Polygons:
    return hull(torch.tensor([corners], dtype=torch.float64))


def random_polygons(size: int, points: int, generator: torch.Generator) -> Polygons:
    spread = torch.rand(size, points, 2, dtype=torch.float64, generator=generator)
    return hull(spread + 0.5 * torch.rand(size, 1, 2, dtype=torch.float64, generator=generator))


def turned(points: Tensor, angle: float = 0.7, shift: tuple[float, float] = (1.3, -2.1)) -> Tensor:
    c, s = math.cos(angle), math.sin(angle)
    return points @ points.new_tensor([[c, s], [-s, c]]) + points.new_tensor(shift)


def true_corners(polygons: Polygons) -> list[list[list[float]]]:
    return [v[:n].tolist() for v, n in zip(polygons.vertices, polygons.count.tolist(), strict=True)]


def in_geos(polygons: Polygons) -> list[shapely.Polygon]:
    return [shapely.Polygon(corners) for corners in true_corners(polygons)]


def test_hull_of_a_square_is_its_corners_counter_clockwise() -> None:
    clutter = [[0.5, 0.5], [0.5, 0.0], [1.0, 0.25], [0.0, 1.0], [1.0, 1.0], [0.0, 0.75], [0.3, 0.9]]
    assert true_corners(polygon(*clutter, *SQUARE)) == [SQUARE]


@pytest.mark.parametrize(
    ("points", "corners"),
    [
        ([[0.3, 0.4]], [[0.3, 0.4]]),
        ([[0.3, 0.4]] * 5, [[0.3, 0.4]]),
        ([[0.0, 0.1], [0.2, 0.1], [0.1, 0.1]], [[0.0, 0.1], [0.2, 0.1]]),
        ([[0.3, 0.5], [0.3, 0.1], [0.3, 0.4], [0.3, 0.1]], [[0.3, 0.1], [0.3, 0.5]]),
        ([[0.0, 0.0], [0.3, 0.1], [0.6, 0.2], [0.9, 0.3]], [[0.0, 0.0], [0.9, 0.3]]),
    ],
)
def test_hull_of_equal_or_collinear_points_is_a_point_or_a_segment(
    points: list[list[float]], corners: list[list[float]]
) -> None:
    assert true_corners(polygon(*points)) == [corners]
    assert hull(turned(torch.tensor([points], dtype=torch.float64))).count.tolist() == [len(corners)]


def test_hull_of_lattice_points_is_that_of_integer_arithmetic(generator: torch.Generator) -> None:
    lattice = torch.randint(0, 5, (2000, 9, 2), generator=generator)
    expected = [integer_hull(sorted(map(tuple, points))) for points in lattice.tolist()]
    found = [
        [tuple(map(int, corner)) for corner in corners] for corners in true_corners(hull(lattice.double()))
    ]
    assert found == expected
    moved = hull(turned(lattice.double()))
    assert moved.count.tolist() == [len(corners) for corners in expected]


def integer_hull(points: list[tuple[int, int]]) -> list[tuple[int, int]]:
    def chain(walk: list[tuple[int, int]]) -> list[tuple[int, int]]:
        kept: list[tuple[int, int]] = []
        for x, y in walk:
            while len(kept) > 1:
                (ax, ay), (bx, by) = kept[-2:]
                if (bx - ax) * (y - ay) - (by - ay) * (x - ax) > 0:
                    break
                kept.pop()
            kept.append((x, y))
        return kept

    walk = sorted(set(points))
    return walk if len(walk) == 1 else chain(walk)[:-1] + chain(walk[::-1])[:-1]


def test_hull_agrees_with_qhull(generator: torch.Generator) -> None:
    for n in (3, 8, 32, 64):
        points = torch.randn(50, n, 2, dtype=torch.float64, generator=generator)
        for corners, cloud in zip(true_corners(hull(points)), points, strict=True):
            expected = cloud[torch.from_numpy(ConvexHull(cloud.numpy()).vertices).long()].tolist()
            start = expected.index(corners[0])
            assert corners == expected[start:] + expected[:start]


def test_hull_of_a_turned_grid_has_four_corners(generator: torch.Generator) -> None:
    ticks = torch.linspace(0.0, 0.3, 8, dtype=torch.float64)
    grid = torch.cartesian_prod(ticks, ticks)
    for angle in torch.linspace(0.0, 2 * math.pi, 50).tolist():
        found = hull(turned(grid, angle)[torch.randperm(64, generator=generator)][None])
        assert found.count.item() == 4
        assert area(found).item() == pytest.approx(0.09, abs=EXACT)


def nearly_regular(generator: torch.Generator) -> Tensor:
    """Lattice points, some squeezed, all shaken by less than rounding or far more, turned, (B, 9, 2)."""
    lattice = torch.randint(0, 4, (3000, 9, 2), generator=generator).double() / 3.0
    shake = 10.0 ** torch.randint(-18, -5, (3000, 1, 1), generator=generator).double()
    squeeze = 10.0 ** torch.randint(-14, 15, (3000, 1), generator=generator).clamp(max=0).double()
    points = lattice + shake * torch.randn(3000, 9, 2, dtype=torch.float64, generator=generator)
    points[..., 1] *= squeeze
    return torch.cat([turned(part, 0.25 * math.pi * k) for k, part in enumerate(points.chunk(8))])


def test_no_point_is_outside_its_hull_however_nearly_regular(generator: torch.Generator) -> None:
    points = nearly_regular(generator)
    found = hull(points)
    outside = torch.stack([signed_distance(found, at) for at in points.unbind(1)])
    assert outside.min().item() > -1e-12
    expected = torch.from_numpy(shapely.area(shapely.convex_hull(shapely.multipoints(points.numpy()))))
    torch.testing.assert_close(area(found), expected, rtol=0.0, atol=1e-12)
    torch.testing.assert_close(area(clip(found, found)), expected, rtol=0.0, atol=1e-12)


def test_absent_points_do_not_move_the_hull(generator: torch.Generator) -> None:
    points = torch.rand(100, 12, 2, dtype=torch.float64, generator=generator)
    present = torch.rand(100, 12, generator=generator) < 0.6
    present[0] = False
    found = hull(torch.where(present[..., None], points, torch.nan), present)
    assert found.count[0].item() == 0
    assert found.vertices[0].abs().max().item() == 0.0
    for k in range(1, 100):
        alone = hull(points[k, present[k]][None])
        assert true_corners(alone) == [true_corners(found)[k]]


def test_rows_past_the_count_repeat_the_last_corner(generator: torch.Generator) -> None:
    for polygons in (random_polygons(50, 9, generator), clip(*(random_polygons(50, 9, generator),) * 2)):
        for vertices, count in zip(polygons.vertices, polygons.count.tolist(), strict=True):
            assert (vertices[count:] == vertices[count - 1]).all()


@pytest.mark.parametrize("shape", [(0, 4, 2), (3, 0, 2)])
def test_hull_of_nothing_is_empty(shape: tuple[int, int, int]) -> None:
    found = hull(torch.zeros(shape, dtype=torch.float64))
    assert found.count.tolist() == [0] * shape[0]
    assert area(found).tolist() == [0.0] * shape[0]
    assert len(clip(found, found)) == shape[0]


def test_hull_names_the_shape_that_it_cannot_use() -> None:
    with pytest.raises(ValueError, match=r"\(sets, points, 2\), but got \(4, 3\)"):
        hull(torch.zeros(4, 3))
    with pytest.raises(ValueError, match=r"flags of shape \(2, 5\), but `present` has \(5,\)"):
        hull(torch.zeros(2, 5, 2), torch.ones(5, dtype=torch.bool))


@pytest.mark.parametrize(
    ("shift", "size", "corners"),
    [
        ((0.5, 0.5), 0.25, 4),  # overlapping
        ((0.0, 0.0), 1.0, 4),  # the same
        ((1.0, 0.0), 0.0, 2),  # touching along an edge
        ((1.0, 0.5), 0.0, 2),  # touching along half an edge
        ((-1.0, -1.0), 0.0, 1),  # touching at a corner
        ((1.0 + 1e-9, 0.0), 0.0, 0),  # a nanometre apart
        ((3.0, 0.0), 0.0, 0),
    ],
)
def test_squares_share_the_overlap_the_edge_or_the_corner(
    shift: tuple[float, float], size: float, corners: int
) -> None:
    square = torch.tensor([SQUARE], dtype=torch.float64)
    other = square + torch.tensor(shift, dtype=torch.float64)
    for angle in (0.0, 0.3, 1.0, 2.5):
        first, second = (hull(turned(p, angle) if angle else p) for p in (square, other))
        for shared in (clip(first, second), clip(second, first)):
            assert area(shared).item() == pytest.approx(size, abs=EXACT)
            assert shared.count.item() == corners


def test_a_polygon_inside_another_is_what_they_share() -> None:
    inner, outer = polygon([0.2, 0.2], [0.6, 0.3], [0.4, 0.7]), polygon(*SQUARE)
    assert true_corners(clip(inner, outer)) == true_corners(inner)
    assert area(clip(outer, inner)).item() == pytest.approx(area(inner).item(), abs=EXACT)


@pytest.mark.parametrize(
    ("first", "second", "shared"),
    [
        ([[0.5, 0.5]], SQUARE, [[0.5, 0.5]]),
        ([[1.0, 0.5]], SQUARE, [[1.0, 0.5]]),
        ([[1.5, 0.5]], SQUARE, []),
        ([[-1.0, 0.5], [0.5, 0.5]], SQUARE, [[0.0, 0.5], [0.5, 0.5]]),
        ([[-1.0, 0.5], [2.0, 0.5]], SQUARE, [[0.0, 0.5], [1.0, 0.5]]),
        ([[-1.0, 1.0], [2.0, 1.0]], SQUARE, [[0.0, 1.0], [1.0, 1.0]]),
        ([[-1.0, 2.0], [2.0, 2.0]], SQUARE, []),
        ([[0.0, 0.0], [1.0, 1.0]], [[0.0, 1.0], [1.0, 0.0]], [[0.5, 0.5]]),
        ([[0.0, 0.0], [2.0, 0.0]], [[1.0, 0.0], [3.0, 0.0]], [[1.0, 0.0], [2.0, 0.0]]),
        ([[0.0, 0.0], [1.0, 0.0]], [[2.0, 0.0], [3.0, 0.0]], []),
        ([[0.0, 0.0], [2.0, 0.0]], [[1.0, 0.0]], [[1.0, 0.0]]),
        ([[0.5, 0.5]], [[0.5, 0.5]], [[0.5, 0.5]]),
        ([[0.5, 0.5]], [[0.5, 0.6]], []),
    ],
)
def test_points_and_segments_clip_like_polygons(
    first: list[list[float]], second: list[list[float]], shared: list[list[float]]
) -> None:
    for one, other in ((first, second), (second, first)):
        found = clip(polygon(*one), polygon(*other))
        assert sorted(true_corners(found)[0]) == shared
        assert area(found).item() == 0.0


def test_clip_agrees_with_geos(generator: torch.Generator) -> None:
    for n in (3, 4, 6, 10, 25):
        first, second = random_polygons(500, n, generator), random_polygons(500, n, generator)
        expected = shapely.area(shapely.intersection(in_geos(first), in_geos(second)))
        for found in (clip(first, second), clip(second, first)):
            assert (area(found) - torch.from_numpy(expected)).abs().max().item() <= 1e-12


def test_clip_agrees_with_rational_arithmetic_near_contact(generator: torch.Generator) -> None:
    first, second = (hull(nearly_regular(generator)[::10]) for _ in range(2))
    for found, one, other in zip(
        area(clip(first, second)).tolist(), rational(first), rational(second), strict=True
    ):
        assert found == pytest.approx(shared_area(one, other), rel=0.0, abs=1e-12)


Corner = tuple[Fraction, Fraction]


def rational(polygons: Polygons) -> list[list[Corner]]:
    return [[(Fraction(x), Fraction(y)) for x, y in corners] for corners in true_corners(polygons)]


def turn(a: Corner, b: Corner, c: Corner) -> Fraction:
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])


def shared_area(subject: list[Corner], clipper: list[Corner]) -> float:
    if len(clipper) < 3:
        return 0.0
    for a, b in zip(clipper, clipper[1:] + clipper[:1], strict=True):
        kept: list[Corner] = []
        for p, q in zip(subject, subject[1:] + subject[:1], strict=True):
            here, there = turn(a, b, p), turn(a, b, q)
            if here >= 0:
                kept.append(p)
            if here * there < 0:
                share = here / (here - there)
                kept.append((p[0] + share * (q[0] - p[0]), p[1] + share * (q[1] - p[1])))
        subject = kept
    return float(sum((turn(subject[0], b, c) for b, c in pairwise(subject)), Fraction(0)) / 2)


def test_what_is_shared_is_convex_and_inside_both(generator: torch.Generator) -> None:
    first, second = random_polygons(500, 8, generator), random_polygons(500, 8, generator)
    shared = clip(first, second)
    assert (area(hull(shared.vertices)) - area(shared)).abs().max().item() < EXACT
    solid = shared.count > 2
    for corner in shared.vertices.unbind(1):
        assert (signed_distance(first, corner)[solid] > -EXACT).all()
        assert (signed_distance(second, corner)[solid] > -EXACT).all()


def test_clip_wants_one_clipper_for_each_subject(generator: torch.Generator) -> None:
    with pytest.raises(ValueError, match="3 subjects came with 2 clippers"):
        clip(random_polygons(3, 5, generator), random_polygons(2, 5, generator))


def test_polygons_of_different_width_stay_the_same_in_one_batch(generator: torch.Generator) -> None:
    parts = [random_polygons(5, n, generator) for n in (1, 3, 20, 2)]
    joined = concatenate(parts)
    assert true_corners(joined) == [corners for part in parts for corners in true_corners(part)]
    assert true_corners(joined[5:10]) == true_corners(parts[1])
    torch.testing.assert_close(area(joined), torch.cat([area(part) for part in parts]), rtol=0.0, atol=EXACT)


def test_area_and_centroid_agree_with_geos_far_from_the_origin(generator: torch.Generator) -> None:
    polygons = hull(torch.rand(300, 9, 2, dtype=torch.float64, generator=generator) + 100.0)
    expected = shapely.get_coordinates(shapely.centroid(in_geos(polygons)))
    torch.testing.assert_close(centroid(polygons), torch.from_numpy(expected), rtol=0.0, atol=EXACT)
    sizes = torch.from_numpy(shapely.area(in_geos(polygons)))
    torch.testing.assert_close(area(polygons), sizes, rtol=0.0, atol=EXACT)


def test_centroid_of_a_segment_is_its_middle_and_of_a_point_itself() -> None:
    assert centroid(polygon([0.0, 0.0], [1.0, 2.0], [0.5, 1.0])).tolist() == [[0.5, 1.0]]
    assert centroid(polygon([0.3, 0.4])).tolist() == [[0.3, 0.4]]
    assert centroid(hull(torch.zeros(1, 0, 2, dtype=torch.float64))).isnan().all()


@pytest.mark.parametrize(
    ("point", "distance"),
    [
        ([0.5, 0.4], 0.4),
        ([0.9, 0.5], 0.1),
        ([1.0, 0.5], 0.0),
        ([1.0, 1.0], 0.0),
        ([1.5, 0.5], -0.5),
        ([1.3, 1.4], -0.5),
        ([-0.3, -0.4], -0.5),
    ],
)
def test_signed_distance_to_a_square_is_positive_inside(point: list[float], distance: float) -> None:
    found = signed_distance(polygon(*SQUARE), torch.tensor([point], dtype=torch.float64))
    assert found.item() == pytest.approx(distance, abs=1e-15)


def test_signed_distance_to_what_has_no_inside_is_never_positive() -> None:
    point = torch.tensor([[3.0, 4.0]], dtype=torch.float64)
    assert signed_distance(polygon([0.0, 0.0]), point).item() == -5.0
    assert signed_distance(polygon([0.0, 0.0], [3.0, 0.0]), point).item() == -4.0
    assert signed_distance(polygon([3.0, 0.0], [3.0, 9.0]), point).item() == 0.0
    assert signed_distance(hull(torch.zeros(1, 0, 2, dtype=torch.float64)), point).isnan().all()


def test_signed_distance_agrees_with_geos(generator: torch.Generator) -> None:
    polygons = random_polygons(1000, 8, generator)
    points = 2.0 * torch.rand(1000, 2, dtype=torch.float64, generator=generator) - 0.2
    geos, at = in_geos(polygons), shapely.points(points.numpy())
    distance = torch.from_numpy(shapely.distance(shapely.boundary(geos), at))
    inside = torch.from_numpy(shapely.contains(geos, at))
    expected = torch.where(inside, distance, -distance)
    torch.testing.assert_close(signed_distance(polygons, points), expected, rtol=0.0, atol=EXACT)


def test_area_centroid_and_distance_are_differentiable(generator: torch.Generator) -> None:
    found = random_polygons(20, 6, generator)
    vertices = found.vertices[found.count == found.count.amax()].requires_grad_()
    count = torch.full((len(vertices),), vertices.shape[1])
    points = (torch.rand(len(vertices), 2, dtype=torch.float64, generator=generator) * 1.5).requires_grad_()
    assert torch.autograd.gradcheck(lambda v: area(Polygons(v, count)), (vertices,))
    assert torch.autograd.gradcheck(lambda v: centroid(Polygons(v, count)), (vertices,))
    assert torch.autograd.gradcheck(lambda v, p: signed_distance(Polygons(v, count), p), (vertices, points))


def test_areas_of_hulls_and_of_what_they_share_are_differentiable(generator: torch.Generator) -> None:
    first, second = (
        torch.rand(2, 10, 6, 2, dtype=torch.float64, generator=generator).requires_grad_().unbind()
    )
    assert torch.autograd.gradcheck(lambda p: area(hull(p)), (first,))
    assert torch.autograd.gradcheck(lambda p, q: area(clip(hull(p), hull(q))), (first, second))


@pytest.mark.parametrize("points", [[[0.3, 0.4]], [[0.0, 0.0], [1.0, 0.5]], SQUARE])
def test_gradients_of_exact_contact_are_finite(points: list[list[float]]) -> None:
    vertices = torch.tensor([points], dtype=torch.float64, requires_grad=True)
    at = vertices.detach()[:, 0].clone().requires_grad_()
    both = hull(vertices)
    (signed_distance(both, at).sum() + area(clip(both, both)).sum() + centroid(both).sum()).backward()
    assert vertices.grad is not None
    assert at.grad is not None
    assert vertices.grad.isfinite().all()
    assert at.grad.isfinite().all()
