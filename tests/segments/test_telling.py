"""What is told of segments: it goes with them, and away with them."""

from __future__ import annotations

from itertools import chain

import pytest
from hypothesis import given
from hypothesis import strategies as st

from blockstab.segments.segmentation import Segment, Segmentation

A, B, C, D = (frozenset(s) for s in ({0, 1}, {2, 3}, {4, 5}, {6}))
START = Segmentation((A, B, C, D)).telling({A: True, B: True, C: False})


@st.composite
def tellings(draw: st.DrawFn) -> Segmentation:
    """Partitions of eight atoms, of some segments of which something is told."""
    owners = draw(st.lists(st.integers(0, 4), min_size=8, max_size=8))
    groups: dict[int, set[int]] = {}
    for atom, owner in enumerate(owners):
        groups.setdefault(owner, set()).add(atom)
    segments = tuple(sorted(map(frozenset, groups.values()), key=min))
    told = {s: b for s in segments if (b := draw(st.sampled_from([True, False, None]))) is not None}
    return Segmentation(segments).telling(told)


masks = st.frozensets(st.integers(0, 7), min_size=1)


def test_what_is_told_is_known_and_of_others_nothing_is() -> None:
    assert START.background == {A: True, B: True, C: False}
    assert Segmentation((A, B)).background == {}


def test_what_is_told_later_counts_and_the_rest_stays() -> None:
    again = START.telling({B: False, D: True})
    assert again.background == {A: True, B: False, C: False, D: True}
    assert START.background[B] is True  # the start is as it was


def test_nothing_can_be_told_of_a_segment_that_is_not_there() -> None:
    assert START.telling({A | B: True}) == START


def test_segmentations_that_know_different_things_are_different() -> None:
    bare = Segmentation(START.segments)
    assert bare != START
    assert bare.telling(START.background) == START
    assert hash(bare.telling({C: False, B: True, A: True})) == hash(START)
    assert len({bare, START, START.telling({D: False})}) == 3


def test_two_that_were_told_alike_are_told_so_as_one() -> None:
    merged = START.merge(0, 1)
    assert merged.background == {A | B: True, C: False}


@pytest.mark.parametrize("pair", [(0, 2), (0, 3), (2, 3)])
def test_two_that_were_told_otherwise_or_not_at_all_leave_the_union_to_be_found_out(pair) -> None:
    merged = START.merge(*pair)
    union = START.segments[pair[0]] | START.segments[pair[1]]
    assert union not in merged.background
    assert merged.background.items() < START.background.items()


def test_parts_are_told_what_the_whole_was_told() -> None:
    one, other = frozenset({0}), frozenset({1})
    assert START.replace(0, (one, other)).background == {one: True, other: True, B: True, C: False}
    again = Segmentation((A, B, C, frozenset({6, 7}))).replace(3, (D, frozenset({7})))
    assert again.background == {}


def test_a_mask_becomes_an_object_and_what_is_left_stays_what_it_was() -> None:
    mask = frozenset({1, 2, 3, 4, 6})
    carved = START.carve(mask)
    assert carved.segments == (frozenset({0}), mask, frozenset({5}))
    assert carved.background == {frozenset({0}): True, mask: False, frozenset({5}): False}


def test_background_that_is_carved_whole_becomes_an_object() -> None:
    assert START.carve(A).segments == START.segments
    assert START.carve(A).background == {**START.background, A: False}


@given(tellings(), masks)
def test_after_carving_every_atom_is_where_it_was_or_in_the_mask(start: Segmentation, mask: Segment) -> None:
    carved = start.carve(mask)
    assert mask in carved.segments
    assert carved.background[mask] is False
    assert sorted(chain(*carved.segments)) == sorted({*chain(*start.segments), *mask})
    assert list(carved.segments) == sorted(carved.segments, key=min)
    for segment in carved.segments:
        if segment != mask:
            (whole,) = (s for s in start.segments if segment <= s)
            assert segment == whole - mask
            assert carved.background.get(segment) == start.background.get(whole)


@given(tellings(), st.data())
def test_replacing_and_merging_back_forgets_nothing(start: Segmentation, data: st.DataObject) -> None:
    index = data.draw(st.integers(0, len(start) - 1))
    whole = start.segments[index]
    if len(whole) > 1:
        part = frozenset(
            data.draw(st.sets(st.sampled_from(sorted(whole)), min_size=1, max_size=len(whole) - 1))
        )
        apart = start.replace(index, (part, whole - part))
        place = sorted(map(apart.segments.index, (part, whole - part)))
        assert apart.merge(*place) == start


@given(tellings(), masks)
def test_what_is_told_is_told_of_segments_that_are_there(start: Segmentation, mask: Segment) -> None:
    moved = [start.carve(mask), *([start.merge(0, 1)] if len(start) > 1 else [])]
    for one in [start, *moved]:
        assert set(one.background) <= set(one.segments)
        assert one.telling({}) == one
