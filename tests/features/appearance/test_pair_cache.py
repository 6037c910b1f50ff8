"""The appearance of pairs of segments: as in an image of these alone, whatever company they are asked for in."""

from __future__ import annotations

from itertools import pairwise

import pytest
import torch
from torch import Tensor

from blockstab.features.appearance.pair_cache import Appearances
from blockstab.features.appearance.pair_columns import (
    APPEARANCE_COLUMNS,
    COURSE_COLUMNS,
    describe_regions,
    edgelet_appearance,
    pair_appearance,
)
from blockstab.features.appearance.regions import Regions
from blockstab.features.appearance.unions import UnionCells
from blockstab.observation import Observation
from blockstab.segments.atoms import Atoms, make_atoms
from blockstab.segments.edgelets import trace_edgelets
from blockstab.segments.outlines import Outlines
from blockstab.segments.segmentation import Pair, Segment
from tests.features.atoms_scene import as_two, clutter, grouped, neighbours
from tests.features.observed import cluttered, observed
from tests.tolerance import COMPANY, EXACT

SEEDS = range(4)
LENGTH = APPEARANCE_COLUMNS.index("relative_length")
BETWEEN = slice(len(COURSE_COLUMNS), None)


def image_wide(observation: Observation, label: Tensor) -> dict[tuple[int, int], Tensor]:
    """By label, the features of every two regions of a label image, 0 = none, as from the image as a whole."""
    edgelets = trace_edgelets(label)
    rows = edgelet_appearance(describe_regions(observation, label), edgelets, observation.boundary_map)
    first, second, features = pair_appearance(rows, edgelets)
    labels = zip((first + 1).tolist(), (second + 1).tolist(), strict=True)
    return dict(zip(labels, features, strict=True))


def scene(seed: int, unlabelled: bool = False) -> tuple[Observation, Atoms, list[Pair]]:
    generator = torch.Generator().manual_seed(seed)
    observation, atoms = clutter(generator, unlabelled)
    return observation, atoms, neighbours(grouped(atoms, generator), atoms)


def close(found: Tensor, expected: Tensor, tolerance: float = EXACT) -> None:
    torch.testing.assert_close(found, expected, rtol=tolerance, atol=tolerance)


@pytest.mark.parametrize("seed", SEEDS)
def test_two_segments_that_fill_an_image_are_as_in_the_image(seed):
    generator = torch.Generator().manual_seed(seed)
    observation, atoms = clutter(generator)
    half = torch.randint(2, (len(atoms),), generator=generator)
    half[0], half[1] = 0, 1
    pair = frozenset((half == 0).nonzero()[:, 0].tolist()), frozenset((half == 1).nonzero()[:, 0].tolist())
    close(Appearances(observation, atoms)([pair])[0], image_wide(observation, as_two(pair, atoms))[1, 2])


@pytest.mark.parametrize("unlabelled", [False, True])
@pytest.mark.parametrize("seed", SEEDS)
def test_all_that_surrounds_a_pair_counts_as_one_region(seed, unlabelled):
    observation, atoms, pairs = scene(seed, unlabelled)
    others = [k for k in range(51) if k != LENGTH or not unlabelled]
    for pair, row in zip(pairs, Appearances(observation, atoms)(pairs), strict=True):
        close(row[others], image_wide(observation, as_two(pair, atoms))[1, 2][others])


@pytest.mark.parametrize("unlabelled", [False, True])
@pytest.mark.parametrize("seed", SEEDS)
def test_what_is_not_told_by_the_course_of_a_border_is_as_in_the_whole_image(seed, unlabelled):
    generator = torch.Generator().manual_seed(seed)
    observation, atoms = clutter(generator, unlabelled)
    segmentation = grouped(atoms, generator)
    expected = image_wide(observation, segmentation.labels(atoms))
    segments = segmentation.segments
    rows = Appearances(observation, atoms)([(segments[i - 1], segments[j - 1]) for i, j in expected])
    for row, wanted in zip(rows, expected.values(), strict=True):
        close(row[BETWEEN], wanted[BETWEEN])
        close(row[LENGTH], wanted[LENGTH])


@pytest.mark.parametrize("seed", SEEDS)
def test_a_pair_is_the_same_within_1e_9_in_whatever_company_it_is_asked_for(seed):
    observation, atoms, pairs = scene(seed, unlabelled=True)
    together = Appearances(observation, atoms)(pairs)
    close(Appearances(observation, atoms)(pairs[::-1]).flip(0), together, COMPANY)
    grown = Appearances(observation, atoms)
    close(torch.cat([grown([pair]) for pair in pairs]), together, COMPANY)
    close(torch.cat([Appearances(observation, atoms)([pair]) for pair in pairs]), together, COMPANY)
    halves = Appearances(observation, atoms)
    later, sooner = halves(pairs[5:]), halves(pairs[:5])
    close(torch.cat([sooner, later]), together, COMPANY)


def test_either_segment_may_come_first():
    observation, atoms, pairs = scene(0)
    swapped = [(second, first) for first, second in pairs]
    known = Appearances(observation, atoms)
    expected = known(pairs)
    assert torch.equal(known(swapped), expected)
    assert len(known) == len(pairs)
    assert torch.equal(Appearances(observation, atoms)(swapped), expected)


def test_one_thread_or_two_give_the_same_bits():
    observation, atoms, pairs = scene(1)
    before = torch.get_num_threads()
    rows = []
    for threads in (1, 2):
        torch.set_num_threads(threads)
        rows.append(Appearances(observation, atoms)(pairs))
    torch.set_num_threads(before)
    assert torch.equal(*rows)


def test_each_segment_and_each_pair_is_measured_once_and_all_new_ones_in_one_batch(monkeypatch):
    observation, atoms, pairs = scene(2)
    measured: list[int] = []
    traced: list[int] = []
    regions, edgelets = UnionCells.regions, Outlines.edgelets

    def counted(self: UnionCells, inside: Tensor) -> Regions:
        measured.append(len(inside))
        return regions(self, inside)

    def traced_one(self: Outlines, first: Tensor, second: Tensor) -> object:
        traced.append(len(first))
        return edgelets(self, first, second)

    monkeypatch.setattr(UnionCells, "regions", counted)
    monkeypatch.setattr(Outlines, "edgelets", traced_one)
    known = Appearances(observation, atoms)
    measured.clear()
    known(pairs[:4])
    known(pairs[:4] + pairs[:2])
    known(pairs)
    known(pairs[2:])
    assert traced == [4, len(pairs) - 4]
    first, everything = {s for pair in pairs[:4] for s in pair}, {s for pair in pairs for s in pair}
    assert measured == [n for n in (len(first), len(everything - first)) if n]
    assert len(known) == len(pairs)


def stripes(*widths: int) -> Tensor:
    """(60, 80) atoms from 1, from left to right."""
    width = torch.tensor([*widths, 80 - sum(widths)])
    return torch.arange(1, len(width) + 1).repeat_interleave(width).expand(60, 80).contiguous()


@pytest.mark.parametrize("flat", [False, True])
@pytest.mark.parametrize("blind", [(), (2,), (1, 2, 3, 4, 5)])
def test_features_are_finite_whatever_a_segment_lacks(flat, blind, generator):
    label = stripes(1, 1, 30, 2)  # atoms of a pixel's width
    label[30, 40] = 6  # and one of a single pixel
    observation = cluttered(label, generator)
    hidden = torch.isin(label, torch.tensor(blind, dtype=torch.int64))
    if flat:
        size = label.shape
        depth = torch.where(hidden, 0.0, torch.ones(size, dtype=torch.float64))
        ahead = torch.tensor([0.0, 0.0, 1.0], dtype=torch.float64).expand(*size, 3)
        grey, planes = torch.zeros(*size, 3, dtype=torch.uint8), torch.zeros(size, dtype=torch.int64)
        observation = observed(depth, ahead, grey, planes, observation.boundary_map.oriented)
    atoms = make_atoms(label, observation.boundary_map.strength)
    pairs: list[Pair] = [(frozenset({i}), frozenset({j})) for i, j in pairwise(range(5))]
    pairs += [(frozenset({0, 2}), frozenset({1, 3})), (frozenset({4}), frozenset({5}))]
    rows = Appearances(observation, atoms)(pairs)
    assert rows.shape == (len(pairs), 51)
    assert bool(rows.isfinite().all())


def test_a_segment_within_another_has_a_border_without_ends(generator):
    label = torch.ones(60, 80, dtype=torch.int64)
    label[20:30, 30:45] = 2
    observation = cluttered(label, generator)
    row = Appearances(observation, make_atoms(label, observation.boundary_map.strength))([segments({0}, {1})])
    close(row[0], image_wide(observation, label)[1, 2])
    found = dict(zip(APPEARANCE_COLUMNS, row[0].tolist(), strict=True))
    assert (found["relative_length"], found["continuity_greatest"]) == (1.0, 0.0)


def test_a_border_continues_in_the_outline_of_either(generator):
    # Above 3, atoms 1 and 2 meet in an upright border; below it their outlines run on to either side.
    label = stripes(40)
    label[30:] = 3
    observation = cluttered(label, generator)
    atoms = make_atoms(label, observation.boundary_map.strength)
    row = Appearances(observation, atoms)([segments({0}, {1})])[0]
    found = dict(zip(APPEARANCE_COLUMNS, row.tolist(), strict=True))
    assert (found["continuity_least"], found["continuity_greatest"]) == pytest.approx((0.0, 90.0))
    assert found["relative_length"] == 30 / 70


def segments(*atoms: set[int]) -> Pair:
    first, second = (frozenset(one) for one in atoms)
    return first, second


def test_no_pair_has_no_row():
    observation, atoms, _ = scene(0)
    assert Appearances(observation, atoms)([]).shape == (0, 51)


def test_segments_that_share_no_border_are_refused(generator):
    label = stripes(20, 20)
    observation = cluttered(label, generator)
    known = Appearances(observation, make_atoms(label, observation.boundary_map.strength))
    with pytest.raises(
        ValueError, match="must share a border, but those of atoms 0 and 2 do not; give pairs"
    ):
        known([segments({0}, {1}), segments({2}, {0})])
    assert len(known) == 0
    assert known([segments({0}, {1})]).shape == (1, 51)


def test_segments_that_share_atoms_are_refused(generator):
    label = stripes(20, 20)
    observation = cluttered(label, generator)
    known = Appearances(observation, make_atoms(label, observation.boundary_map.strength))
    both: list[Segment] = [frozenset({0, 1}), frozenset({1, 2})]
    with pytest.raises(ValueError, match=r"must not share atoms, but both have \[1\]; give pairs"):
        known([(both[0], both[1])])
