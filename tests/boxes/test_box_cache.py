"""Boxes fitted once and gaps measured once, for all segmentations of an image."""

from __future__ import annotations

from itertools import chain, combinations

import pytest
import torch
from torch import Tensor

from blockstab.boxes import box_cache as box_cache_module
from blockstab.boxes.box import Boxes
from blockstab.boxes.box_cache import BoxCache, SegmentPoints
from blockstab.boxes.fitting import Fits, MinimumSurface
from blockstab.boxes.separation import Separation, separation
from blockstab.segments.segmentation import Segment
from tests.tolerance import COMPANY

ATOMS, PIXELS = 8, 1200
UP = [0.0, 1.0, 0.0]
FREE = [float("nan")] * 3


class Counting:
    """A fitter that remembers how many boxes it was asked for, call by call."""

    def __init__(self, max_points: int = 100) -> None:
        self.max_points = max_points
        self.calls: list[int] = []
        self._fit = MinimumSurface(max_points=max_points)

    def __call__(self, points: Tensor, count: Tensor, seed: Tensor, axis: Tensor | None = None) -> Fits:
        self.calls.append(len(points))
        return self._fit(points, count, seed, axis)


@pytest.fixture
def pixels(generator: torch.Generator) -> tuple[Tensor, Tensor]:
    """Points of a clutter of atoms of very different sizes, and the atom of each."""
    weight = torch.tensor([1.0, 2.0, 4.0, 8.0, 16.0, 32.0, 64.0, 128.0])
    atom = torch.multinomial(weight, PIXELS, True, generator=generator)
    atom[:ATOMS] = torch.arange(ATOMS)
    middle = 0.4 * torch.randn(ATOMS, 3, generator=generator, dtype=torch.float64)
    spread = 0.05 * torch.randn(PIXELS, 3, generator=generator, dtype=torch.float64)
    return middle[atom] + spread + torch.tensor([0.0, 0.0, -1.5], dtype=torch.float64), atom


@pytest.fixture
def box_cache(pixels: tuple[Tensor, Tensor]) -> BoxCache:
    return BoxCache(SegmentPoints(*pixels, ATOMS, 100), Counting())


def calls(box_cache: BoxCache) -> list[int]:
    assert isinstance(box_cache.fitter, Counting)
    return box_cache.fitter.calls


def segments(*atoms: tuple[int, ...]) -> list[Segment]:
    return [frozenset(one) for one in atoms]


def test_a_segment_is_fitted_once_ever(box_cache: BoxCache) -> None:
    first = box_cache.rows(segments((0, 1), (2,), (3, 4)))
    again = box_cache.rows(segments((3, 4), (5,), (1, 0), (2,)))
    assert calls(box_cache) == [3, 1]
    assert again.tolist() == [2, 3, 0, 1]
    assert first.tolist() == [0, 1, 2]
    assert len(box_cache) == len(box_cache.fits) == 4


def test_a_segment_named_twice_in_one_call_is_fitted_once(box_cache: BoxCache) -> None:
    assert box_cache.rows(segments((0,), (1,), (0,))).tolist() == [0, 1, 0]
    assert calls(box_cache) == [2]


def test_each_axis_is_a_fit_of_its_own_and_made_once(box_cache: BoxCache) -> None:
    named = segments((6,), (7,), (6,))
    axes = torch.tensor([UP, FREE, FREE], dtype=torch.float64)
    rows = box_cache.rows(named, axes)
    assert len(rows.unique()) == 3
    assert sorted(calls(box_cache)) == [1, 2]
    assert torch.equal(box_cache.rows(named, axes), rows)
    assert box_cache.rows(segments((7,))).tolist() == [int(rows[1])]
    assert sum(calls(box_cache)) == 3
    upright = box_cache.fits.boxes.rotation[rows[0]]
    assert float(upright[1].abs().max()) > 1 - 1e-9


def test_the_box_of_a_segment_is_the_same_within_1e_9_whenever_it_is_asked_for(
    pixels: tuple[Tensor, Tensor],
) -> None:
    asked = [segments((0,), (1,), (2, 3), (4, 5, 6), (7,)), segments((4, 5, 6)), segments((7,), (2, 3))]
    wanted = segments((2, 3), (4, 5, 6), (7,))
    found = []
    for order in (asked, asked[::-1], [asked[1]]):
        box_cache = BoxCache(SegmentPoints(*pixels, ATOMS, 100), Counting())
        for one in order:
            box_cache.rows(one)
        rows = box_cache.rows(wanted)
        fits = box_cache.fits[rows]
        found.append((fits.boxes.center, fits.boxes.rotation, fits.boxes.half_extent, fits.mean))
    for other in found[1:]:
        for a, b in zip(found[0], other, strict=True):
            torch.testing.assert_close(a, b, rtol=0.0, atol=COMPANY)


def measured(box_cache: BoxCache, first: Tensor, second: Tensor) -> Separation:
    return separation(box_cache.fits.boxes, first, second)


def test_gaps_are_those_of_measuring_directly_within_1e_9(box_cache: BoxCache) -> None:
    rows = box_cache.rows(segments(*((k,) for k in range(ATOMS))))
    first, second = (rows[index] for index in torch.triu_indices(ATOMS, ATOMS, 1))
    for upper in (slice(None), slice(3, 9), slice(None, None, 2)):
        found = box_cache.separation(first[upper], second[upper])
        direct = measured(box_cache, first[upper], second[upper])
        torch.testing.assert_close(found.gap, direct.gap, rtol=0.0, atol=COMPANY)
        torch.testing.assert_close(found.direction, direct.direction, rtol=0.0, atol=COMPANY)


def test_a_pair_named_the_other_way_round_has_the_same_gap_and_the_opposite_direction(
    box_cache: BoxCache,
) -> None:
    rows = box_cache.rows(segments(*((k,) for k in range(ATOMS))))
    first, second = (rows[index] for index in torch.triu_indices(ATOMS, ATOMS, 1))
    back, forth = box_cache.separation(second, first), box_cache.separation(first, second)
    assert torch.equal(back.gap, forth.gap)
    assert torch.equal(back.direction, -forth.direction)
    mixed = box_cache.separation(torch.cat([first[:1], second[:1]]), torch.cat([second[:1], first[:1]]))
    assert torch.equal(mixed.direction[0], -mixed.direction[1])


def test_each_pair_is_measured_once(box_cache: BoxCache, monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[int] = []

    def counted(boxes: Boxes, first: Tensor, second: Tensor) -> Separation:
        asked.append(len(first))
        return separation(boxes, first, second)

    monkeypatch.setattr(box_cache_module, "separation", counted)
    rows = box_cache.rows(segments(*((k,) for k in range(ATOMS))))
    first, second = (rows[index] for index in torch.triu_indices(ATOMS, ATOMS, 1))
    some = torch.tensor([4, 1, 9, 4])
    box_cache.separation(first[some], second[some])
    box_cache.separation(first, second)
    box_cache.separation(second, first)
    assert asked == [3, 25]
    box_cache.rows(segments((0, 1)))
    new = torch.full((ATOMS,), ATOMS)
    box_cache.separation(new, rows)
    assert asked == [3, 25, ATOMS]


def test_no_pairs_have_no_gaps(box_cache: BoxCache) -> None:
    none = box_cache.rows([])
    assert none.tolist() == []
    assert box_cache.separation(none, none).gap.tolist() == []
    assert calls(box_cache) == []


def test_a_variant_replaces_a_changed_box_and_keeps_the_row_of_an_unchanged_one(
    box_cache: BoxCache,
) -> None:
    rows = box_cache.rows(segments((5,), (6,), (7,)))
    old = box_cache.fits.boxes[rows]
    longer = Boxes(old.center.clone(), old.rotation, old.half_extent.clone())
    longer.center[1, 1] -= 0.1
    longer.half_extent[1, 1] += 0.1
    new = box_cache.variants(rows, longer)
    assert new.tolist() == [0, 3, 2]
    assert torch.equal(box_cache.fits.boxes.half_extent[new], longer.half_extent)
    assert torch.equal(box_cache.fits.mean[new], box_cache.fits.mean[rows])
    assert torch.equal(box_cache.variants(rows, longer), new)
    assert torch.equal(box_cache.fitted(new), rows)
    assert torch.equal(box_cache.variants(rows, old), rows)
    assert len(box_cache.fits) == 4
    assert calls(box_cache) == [3]


def test_the_gaps_of_a_variant_are_its_own(box_cache: BoxCache) -> None:
    rows = box_cache.rows(segments((6,), (7,)))
    old = box_cache.fits.boxes[rows]
    before = box_cache.separation(rows[:1], rows[1:])
    moved = Boxes(old.center + torch.tensor([[5.0, 0, 0], [0, 0, 0]]).double(), old.rotation, old.half_extent)
    new = box_cache.variants(rows, moved)
    after = box_cache.separation(new[:1], new[1:])
    assert float(after.gap) > float(before.gap) + 3
    assert torch.equal(after.gap, measured(box_cache, new[:1], new[1:]).gap)
    assert torch.equal(box_cache.separation(rows[:1], rows[1:]).gap, before.gap)


def test_a_union_has_the_same_points_however_it_was_composed(pixels: tuple[Tensor, Tensor]) -> None:
    points, atom = pixels
    fine = SegmentPoints(points, atom, ATOMS, 100)
    whole = fine.gather(segments((0, 1, 2, 3, 4)))
    for merged in combinations(range(5), 2):
        # The same pixels, of which two atoms are one.
        coarse = torch.where(atom == merged[1], merged[0], atom)
        rest = tuple(k for k in range(5) if k != merged[1])
        again = SegmentPoints(points, coarse, ATOMS, 100).gather(segments(rest))
        assert all(torch.equal(a, b) for a, b in zip(whole, again, strict=True))


def test_no_segment_has_more_points_than_allowed_nor_fewer_than_it_could(
    pixels: tuple[Tensor, Tensor],
) -> None:
    points, atom = pixels
    choice = segments(*chain.from_iterable(combinations(range(ATOMS), size) for size in (1, 2, 5)))
    gathered, count, _ = SegmentPoints(points, atom, ATOMS, 70).gather(choice)
    assert gathered.shape == (len(choice), 70, 3)
    for found, number, segment in zip(gathered, count.tolist(), choice, strict=True):
        own = points[torch.isin(atom, torch.tensor(sorted(segment)))]
        assert number == min(70, len(own))
        rows = {tuple(p) for p in found[:number].tolist()}
        assert len(rows) == number  # none twice
        assert rows <= {tuple(p) for p in own.tolist()}
        assert bool((found[number:] == found[0]).all())


def test_fewer_points_are_the_first_of_more(pixels: tuple[Tensor, Tensor]) -> None:
    choice = segments((7,), (6, 7), (0,), tuple(range(ATOMS)))
    many, _, _ = SegmentPoints(*pixels, ATOMS, 300).gather(choice)
    few, count, _ = SegmentPoints(*pixels, ATOMS, 40).gather(choice)
    for a, b, number in zip(few, many, count.tolist(), strict=True):
        assert torch.equal(a[:number], b[:number])


def test_a_prefix_of_the_points_is_a_fair_sample_of_the_atoms(pixels: tuple[Tensor, Tensor]) -> None:
    points, atom = pixels
    gathered, _, _ = SegmentPoints(points, atom, ATOMS, 400).gather(segments((6, 7)))
    share = float(torch.isin(gathered[0, :, 0], points[atom == 7, 0]).double().mean())
    true = float((atom == 7).sum()) / float((atom >= 6).sum())
    assert share == pytest.approx(true, abs=0.08)


def test_segments_of_different_pixels_have_different_seeds(pixels: tuple[Tensor, Tensor]) -> None:
    choice = segments(*chain.from_iterable(combinations(range(ATOMS), size) for size in range(1, ATOMS + 1)))
    _, _, seed = SegmentPoints(*pixels, ATOMS, PIXELS).gather(choice)
    assert len(seed.unique()) > 0.95 * len(choice)
