"""Segmentations are values: moves make new ones, and equal partitions are equal."""

from __future__ import annotations

from dataclasses import fields

import pytest
import torch
from hypothesis import given
from hypothesis import strategies as st
from torch import Tensor

from blockstab.segments.atoms import Atoms, make_atoms
from blockstab.segments.segmentation import Segmentation

ROWS, COLUMNS, SIDE = 3, 4, 6


def grid() -> Atoms:
    """Twelve square atoms of 36 pixels in three rows."""
    numbers = 1 + torch.arange(ROWS * COLUMNS).view(ROWS, COLUMNS)
    label = numbers.repeat_interleave(SIDE, dim=0).repeat_interleave(SIDE, dim=1)
    return make_atoms(label, torch.zeros(label.shape, dtype=torch.float64))


def segmentation(*segments: set[int]) -> Segmentation:
    return Segmentation(tuple(frozenset(s) for s in segments))


@st.composite
def partitions(draw: st.DrawFn) -> Segmentation:
    """Partitions of some of the twelve atoms."""
    owners = draw(st.lists(st.integers(-1, 5), min_size=12, max_size=12).filter(lambda o: max(o) >= 0))
    groups: dict[int, set[int]] = {}
    for atom, owner in enumerate(owners):
        if owner >= 0:
            groups.setdefault(owner, set()).add(atom)
    return segmentation(*sorted(groups.values(), key=min))


def test_merging_orders_segments_by_their_smallest_atom() -> None:
    start = segmentation({0}, {1, 4}, {2}, {3})
    assert start.merge(3, 0) == segmentation({0, 3}, {1, 4}, {2})


def test_replacing_orders_segments_by_their_smallest_atom() -> None:
    start = segmentation({0, 3}, {1, 2})
    assert start.replace(0, (frozenset({3}), frozenset({0}))) == segmentation({0}, {1, 2}, {3})


@pytest.mark.parametrize("parts", [[{0}], [{0}, {3}, set()], [{0, 3}, {3}], [{0}, {3, 1}]])
def test_parts_that_do_not_divide_the_segment_are_refused(parts: list[set[int]]) -> None:
    with pytest.raises(ValueError, match=r"atoms of segment 0, \[0, 3\]"):
        segmentation({0, 3}, {1}).replace(0, [frozenset(p) for p in parts])


def test_a_segment_cannot_merge_with_itself() -> None:
    with pytest.raises(ValueError, match="both are 1"):
        segmentation({0}, {1}).merge(1, 1)


@given(start=partitions(), data=st.data())
def test_merging_the_parts_of_a_split_returns_the_start(start: Segmentation, data: st.DataObject) -> None:
    index = data.draw(st.integers(0, len(start) - 1))
    whole = sorted(start.segments[index])
    first = frozenset(data.draw(st.sets(st.sampled_from(whole), min_size=1)))
    rest = frozenset(whole) - first
    if not rest:
        return
    apart = start.replace(index, (first, rest))
    again = apart.merge(apart.segments.index(rest), apart.segments.index(first))
    assert again == start
    assert hash(again) == hash(start)


@given(start=partitions(), data=st.data())
def test_every_atom_stays_in_one_segment_and_nothing_changes_in_place(
    start: Segmentation, data: st.DataObject
) -> None:
    atoms = sorted(a for s in start.segments for a in s)
    now = start
    for _ in range(data.draw(st.integers(1, 6))):
        before, copy = now, tuple(frozenset(s) for s in now.segments)
        if len(now) > 1 and data.draw(st.booleans()):
            pair = data.draw(st.permutations(range(len(now))))[:2]
            now = now.merge(*pair)
        else:
            index = data.draw(st.integers(0, len(now) - 1))
            now = now.replace(index, [frozenset({a}) for a in now.segments[index]])
        assert before.segments == copy
        assert sorted(a for s in now.segments for a in s) == atoms
        assert list(now.segments) == sorted(now.segments, key=min)


@given(start=partitions())
def test_a_label_image_gives_its_segmentation_back(start: Segmentation) -> None:
    atoms = grid()
    assert Segmentation.from_labels(atoms, start.labels(atoms)) == start


@given(start=partitions())
def test_neighbours_are_those_that_share_enough_border(start: Segmentation) -> None:
    atoms = grid()
    assert _pairs(start.neighbours(atoms, 2 * SIDE)) == _shared(start, atoms, 2 * SIDE)
    assert _pairs(start.neighbours(atoms)) == _shared(start, atoms, 5)


def _pairs(neighbours: tuple[Tensor, Tensor]) -> list[tuple[int, int]]:
    return list(zip(*(index.tolist() for index in neighbours), strict=True))


def _shared(now: Segmentation, atoms: Atoms, least: int) -> list[tuple[int, int]]:
    label = now.labels(atoms)
    found = []
    for i in range(1, len(now) + 1):
        for j in range(i + 1, len(now) + 1):
            sides = (label[:-1], label[1:]), (label[:, :-1], label[:, 1:])
            meet = sum(int((((a == i) & (b == j)) | ((a == j) & (b == i))).sum()) for a, b in sides)
            found += [(i - 1, j - 1)] if meet >= least else []
    return found


def test_convention_label_image() -> None:
    atoms = grid()
    label = segmentation({0, 1}, {5}).labels(atoms)
    assert label.dtype == torch.int64
    assert label.unique().tolist() == [0, 1, 2]
    assert torch.equal(label == 1, (atoms.label == 1) | (atoms.label == 2))
    assert torch.equal(label == 2, atoms.label == 6)


def test_an_atom_goes_with_most_of_its_pixels() -> None:
    atoms = grid()
    label = torch.full(atoms.label.shape, 40)
    label[:SIDE, : SIDE - 2] = 7  # most of atom 0
    label[:SIDE, SIDE : 2 * SIDE - 2] = 0  # most of atom 1
    assert Segmentation.from_labels(atoms, label) == segmentation({0}, set(range(2, 12)))


def test_labels_of_another_size_are_refused() -> None:
    with pytest.raises(ValueError, match="size of the atoms"):
        Segmentation.from_labels(grid(), torch.ones(3, 3, dtype=torch.int64))


def test_an_empty_segmentation_has_no_labels_and_no_neighbours() -> None:
    atoms = grid()
    empty = Segmentation.from_labels(atoms, torch.zeros_like(atoms.label))
    assert len(empty) == 0
    assert not empty.labels(atoms).any()
    assert _pairs(empty.neighbours(atoms)) == []


def test_atoms_are_not_changed_by_what_is_asked_of_a_segmentation() -> None:
    atoms, again = grid(), grid()
    start = segmentation({0, 1}, {2, 5})
    start.labels(atoms)
    start.neighbours(atoms)
    start.index_of_atom(len(atoms))
    for field in fields(atoms):
        assert torch.equal(getattr(atoms, field.name), getattr(again, field.name))
