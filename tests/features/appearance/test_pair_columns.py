"""The 51 features: what each group answers to, and what must hold for all."""

from __future__ import annotations

from dataclasses import replace

import pytest
import torch
from torch import Tensor

from blockstab.boundaries import BoundaryMap
from blockstab.features.appearance.contrast import CONTRAST_COLUMNS, contrast
from blockstab.features.appearance.pair_columns import (
    APPEARANCE_COLUMNS,
    Variant,
    describe_regions,
    edgelet_appearance,
    pair_appearance,
)
from blockstab.observation import Observation
from blockstab.segments.edgelets import trace_edgelets
from tests.features.observed import HEIGHT, WIDTH, cells, cluttered, observed
from tests.tolerance import EXACT

VARIANTS: tuple[Variant, ...] = ("fixed", "released")
DIFFERENT = [3, 11, 17, 20, *range(23, 32), 38, *range(43, 52)]  # columns from 1


def appearance(observation: Observation, label: Tensor, variant: Variant = "fixed") -> Tensor:
    return edgelet_appearance(
        describe_regions(observation, label), trace_edgelets(label), observation.boundary_map, variant
    )


def column(rows: Tensor, name: str) -> list[float]:
    return rows[:, APPEARANCE_COLUMNS.index(name)].tolist()


def corner_scene(color: Tensor | None = None) -> tuple[Observation, Tensor]:
    """A wall straight ahead above a floor; the wall's label is 1."""
    size = (HEIGHT, WIDTH)
    label = torch.ones(size, dtype=torch.int64)
    label[HEIGHT // 2 + 10 :] = 2
    v = torch.arange(HEIGHT).double()[:, None].expand(size)
    drop = (HEIGHT // 2 + 10 - (HEIGHT - 1) / 2) / 80.0
    depth = torch.where(label == 1, 1.0, drop / ((v - (HEIGHT - 1) / 2) / 80.0).clamp(min=drop))
    ways = torch.tensor([[0, 0, 0], [0, 0, 1], [0, 1, 0]], dtype=torch.float64)
    color = torch.full((*size, 3), 100, dtype=torch.uint8) if color is None else color
    oriented = torch.zeros(4, *size, dtype=torch.float64)
    return observed(depth, ways[label], color, label - 1, oriented), label


def test_there_are_51_columns_of_different_names() -> None:
    assert len(APPEARANCE_COLUMNS) == len(set(APPEARANCE_COLUMNS)) == 51


@pytest.mark.parametrize("seed", range(3))
def test_no_two_columns_are_the_same(seed: int) -> None:
    generator = torch.Generator().manual_seed(seed)
    label = cells(25, generator)
    rows = appearance(cluttered(label, generator), label)
    assert bool(rows.isfinite().all())
    for i in range(51):
        for j in range(i):
            assert not torch.allclose(rows[:, i], rows[:, j]), (APPEARANCE_COLUMNS[i], APPEARANCE_COLUMNS[j])


def test_the_released_variant_repeats_columns(generator: torch.Generator) -> None:
    label = cells(25, generator)
    observation = cluttered(label, generator)
    fixed, released = (appearance(observation, label, variant) for variant in VARIANTS)
    assert torch.equal(released[:, 10], released[:, 8])
    assert torch.equal(released[:, 37], released[:, 36])
    assert torch.allclose(released[:, 50], 2 * released[:, 42:46].sum(dim=1), atol=EXACT)
    assert torch.allclose(released[:, 30], released[:, 14:21].sum(dim=1))
    assert [k + 1 for k in range(51) if not torch.equal(fixed[:, k], released[:, k])] == DIFFERENT


def test_totals_are_the_sums_of_their_columns(generator: torch.Generator) -> None:
    label = cells(25, generator)
    rows = appearance(cluttered(label, generator), label)
    assert torch.allclose(rows[:, 30], rows[:, 23:30].sum(dim=1))
    assert torch.allclose(rows[:, 50], rows[:, 42:50].sum(dim=1))


def test_as_released_normals_do_not_turn_with_the_room(generator: torch.Generator) -> None:
    observation, label = corner_scene()
    tilted = replace(observation.ground, world_from_camera=observation.ground.world_from_camera[[1, 0, 2]])
    turned = type(observation)(**{**vars(observation), "ground": tilted})
    assert torch.equal(appearance(observation, label), appearance(turned, label))
    assert not torch.equal(appearance(observation, label, "released"), appearance(turned, label, "released"))


@pytest.mark.parametrize("variant", VARIANTS)
def test_regions_may_be_named_in_either_order(variant: Variant, generator: torch.Generator) -> None:
    label = cells(15, generator)
    observation = cluttered(label, generator)
    swapped = int(label.max()) + 1 - label
    edgelets, other = trace_edgelets(label), trace_edgelets(swapped)
    rows = pair_appearance(appearance(observation, label, variant), edgelets)
    same = pair_appearance(appearance(observation, swapped, variant), other)
    back = int(label.max()) - 1
    order = ((back - same[1]) * (back + 1) + back - same[0]).argsort()
    assert torch.equal(rows[0], back - same[1][order])
    assert torch.allclose(rows[2], same[2][order], rtol=EXACT, atol=EXACT)


@pytest.mark.parametrize("variant", VARIANTS)
@pytest.mark.parametrize("flat", [False, True])
def test_regions_of_a_pixels_width_have_finite_features(
    variant: Variant, flat: bool, generator: torch.Generator
) -> None:
    label = cells(6, generator)
    label[:, 40], label[20], label[20, 40] = 7, 8, 9
    label = torch.unique(label, return_inverse=True)[1] + 1
    observation = cluttered(label, generator)
    if flat:
        size = label.shape
        depth = torch.ones(size, dtype=torch.float64)
        depth[label == 2] = 0.0
        oriented, grey = observation.boundary_map.oriented, torch.zeros(*size, 3, dtype=torch.uint8)
        ahead = torch.tensor([0.0, 0.0, 1.0], dtype=torch.float64).expand(*size, 3)
        observation = observed(depth, ahead, grey, torch.zeros(size, dtype=torch.int64), oriented)
    assert bool(appearance(observation, label, variant).isfinite().all())


def test_a_picture_without_borders_has_no_rows() -> None:
    observation, label = corner_scene()
    edgelets = trace_edgelets(torch.ones_like(label))
    rows = appearance(observation, torch.ones_like(label))
    assert rows.shape == (0, 51)
    assert pair_appearance(rows, edgelets)[2].shape == (0, 51)


@pytest.mark.parametrize(("channel", "expected"), [(0, 0.7), (1, 0.0), (2, 0.0), (3, 0.0)])
@pytest.mark.parametrize("beside", [-3, -2, 1, 2])
def test_strength_is_read_where_edges_run_along_the_border(
    channel: int, expected: float, beside: int
) -> None:
    observation, label = corner_scene()
    oriented = torch.zeros(4, HEIGHT, WIDTH, dtype=torch.float64)
    oriented[channel, HEIGHT // 2 + 10 + beside] = 0.7
    edgelets = trace_edgelets(label)
    rows = edgelet_appearance(
        describe_regions(observation, label), edgelets, BoundaryMap(oriented, oriented.amax(dim=0))
    )
    assert column(rows, "strength") == pytest.approx([expected])


def test_an_edge_three_pixels_away_is_not_the_borders() -> None:
    observation, label = corner_scene()
    oriented = torch.zeros(4, HEIGHT, WIDTH, dtype=torch.float64)
    oriented[:, HEIGHT // 2 + 10 + 3] = 0.7
    oriented[:, HEIGHT // 2 + 10 - 4] = 0.7
    rows = edgelet_appearance(
        describe_regions(observation, label),
        trace_edgelets(label),
        BoundaryMap(oriented, oriented.amax(dim=0)),
    )
    assert column(rows, "strength") == [0.0]


def test_a_floor_and_a_wall_differ_in_direction_and_plane() -> None:
    observation, label = corner_scene()
    rows = appearance(observation, label)
    for name, expected in {
        "normal": 2.0,
        "horizontal": 1.0,
        "vertical": 1.0,
        "vertical_no_wall": 0.0,
        "slanted": 0.0,
        "planes": 2.0,
        "relative_length": 1.0,
        "smoothness": 1.0,
        "area_smaller": 20 / 60,
        "area_larger": 40 / 60,
        "residual_greatest": 0.0,
        "color_mean_interior": 0.0,
        "lowest": 0.0,
    }.items():
        assert column(rows, name) == pytest.approx([expected], abs=EXACT), name
    assert column(rows, "other_residual_mean")[0] > 0.05


def test_colors_differ_by_their_distance_in_ycbcr() -> None:
    color = torch.full((HEIGHT, WIDTH, 3), 100, dtype=torch.uint8)
    color[HEIGHT // 2 + 10 :] = 151
    rows = appearance(*corner_scene(color))
    assert column(rows, "color_mean_interior") == pytest.approx([51 / 255])
    assert column(rows, "color_mean_border") == pytest.approx([51 / 255])
    assert column(rows, "color_deviation_border") == pytest.approx([0.0], abs=1e-7)


def test_gaps_and_overlaps_are_those_of_upright_boxes() -> None:
    observation, label = corner_scene()
    regions = describe_regions(observation, label)
    least = torch.tensor([[0.0, 0.0, 0.0], [2.0, 1.0, 5.0], [0.5, 0.5, 0.5]], dtype=torch.float64)
    places = replace(regions.places, least=least[:2], greatest=least[:2] + 1.0, mean=least[:2] + 0.5)
    rows = contrast(replace(regions, places=places), torch.tensor([0]), torch.tensor([1]), "fixed")
    found = dict(zip(CONTRAST_COLUMNS, rows[0].tolist(), strict=True))
    assert found["gap"] == pytest.approx(17**0.5)
    assert found["footprint_gap"] == pytest.approx(17**0.5)
    assert found["centroid_distance"] == pytest.approx(30**0.5)
    assert found["footprint_distance"] == pytest.approx(29**0.5)
    assert found["volume_overlap"] == found["footprint_overlap"] == 0.0
    places = replace(places, least=least[[0, 2]], greatest=least[[0, 2]] + 1.0)
    rows = contrast(replace(regions, places=places), torch.tensor([0]), torch.tensor([1]), "released")
    found = dict(zip(CONTRAST_COLUMNS, rows[0].tolist(), strict=True))
    assert found["gap"] == found["footprint_gap"] == 0.0
    assert found["volume_overlap"] == pytest.approx(0.125)
    assert found["footprint_overlap"] == pytest.approx(0.25)


def test_pairs_pool_their_edgelets(generator: torch.Generator) -> None:
    label = torch.ones(HEIGHT, WIDTH, dtype=torch.int64)
    label[:, 50:] = 2
    label[20:30, 45:55] = 3  # which cuts the border of 1 and 2 in pieces of 20 and 30
    edgelets = trace_edgelets(label)
    rows = appearance(cluttered(label, generator), label)
    first, second, pooled = pair_appearance(rows, edgelets)
    assert list(zip(first.tolist(), second.tolist(), strict=True)) == [(0, 1), (0, 2), (1, 2)]
    pieces = rows[:2]
    assert edgelets.length[:2].tolist() == [20.0, 30.0]
    assert float(pooled[0, 0]) == pytest.approx(float(pieces[:, 0] @ torch.tensor([0.4, 0.6]).double()))
    assert float(pooled[0, 1]) == pytest.approx(float(pieces[:, 1].sum()))
    assert float(pooled[0, 2]) == pytest.approx(float(pieces[:, 2] @ torch.tensor([0.4, 0.6]).double()))
    assert float(pooled[0, 3]) == float(pieces[:, 3].min())
    assert float(pooled[0, 4]) == float(pieces[:, 4].max())
    assert torch.equal(pooled[0, 5:], pieces[0, 5:])
