"""Which columns there are, and the sets of them that training may choose."""

from __future__ import annotations

import pytest
from hydra.utils import instantiate

from blockstab.features.box_shape import BOX_SHAPE_COLUMNS
from blockstab.features.columns import (
    COLUMNS,
    FEATURE_SETS,
    LONE_COLUMNS,
    PAPER,
    SEGMENT_COLUMNS,
    computed,
    feature_set,
)
from blockstab.features.contour import CONTOUR_COLUMNS
from blockstab.features.pairwise import PAIRWISE_COLUMNS
from blockstab.features.surface import SURFACE_COLUMNS
from blockstab.features.unary import UNARY_COLUMNS
from models.potentials.rows import KINDS
from tests.docs.pages import composed
from tests.own_columns import Height

# What boxes say only once it is asked what stands on what.
STABILITY = {
    "stable", "stable_alone", "offset_from_support", "offset_from_support_relative",
    "stable_larger", "stable_smaller",
    "support_surface", "support_partial", "support_side", "supporting",
    # From the centre of mass of a box with all that rests on it.
    *(f"offset_from_corner_{k}" for k in range(8)), *(f"offset_from_corner_{k}_relative" for k in range(8)),
}  # fmt: skip


@pytest.mark.parametrize("kind", COLUMNS)
def test_every_column_has_a_name_of_its_own(kind):
    assert len(set(COLUMNS[kind])) == len(COLUMNS[kind])


def test_columns_are_those_of_their_parts_in_order():
    assert (*UNARY_COLUMNS, *BOX_SHAPE_COLUMNS, *LONE_COLUMNS) == SEGMENT_COLUMNS
    assert (*CONTOUR_COLUMNS, *SURFACE_COLUMNS) == LONE_COLUMNS
    assert tuple(COLUMNS) == KINDS
    assert COLUMNS["alone"] == COLUMNS["background"] == LONE_COLUMNS
    assert COLUMNS["pairwise"] == PAIRWISE_COLUMNS


def test_columns_of_ones_own_stand_after_ours_for_segments_in_a_scene_and_are_all_chosen():
    assert computed([Height()]) == {**COLUMNS, "unary": (*SEGMENT_COLUMNS, "height")}
    assert feature_set("paper").of("unary", [Height()]) == (*UNARY_COLUMNS, "height")
    for kind in ("pairwise", "alone", "background"):
        assert feature_set("paper").of(kind, [Height()]) == feature_set("paper").of(kind)


def test_two_columns_of_one_name_are_refused():
    with pytest.raises(ValueError, match="height came twice"):
        computed([Height(), Height(0.5)])


def test_the_papers_set_is_table_1():
    assert feature_set("paper") is PAPER
    assert (len(PAPER.unary), len(PAPER.pairwise)) == (30, 63)
    assert PAPER.unary == UNARY_COLUMNS


def test_without_stability_exactly_what_stability_says_is_missing():
    less = feature_set("paper_without_stability")
    assert set(PAPER.unary) - set(less.unary) == STABILITY & set(UNARY_COLUMNS)
    assert set(PAPER.pairwise) - set(less.pairwise) == STABILITY & set(PAIRWISE_COLUMNS)
    assert not STABILITY & {*less.unary, *less.pairwise}
    assert list(less.unary) == [name for name in PAPER.unary if name in less.unary]  # in order


@pytest.mark.parametrize("name", FEATURE_SETS)
def test_every_set_is_of_columns_that_are_computed(name):
    for kind in COLUMNS:
        chosen = feature_set(name).of(kind)
        assert set(chosen) <= set(COLUMNS[kind])
        assert list(chosen) == sorted(chosen, key=COLUMNS[kind].index)
    assert feature_set(name).of("alone") == feature_set(name).of("background") == LONE_COLUMNS


@pytest.mark.parametrize("name", FEATURE_SETS)
def test_every_set_can_be_chosen_for_training(name):
    assert instantiate(composed("train", [f"features={name}"]).features) == feature_set(name)


def test_a_misspelt_set_is_refused_and_the_sets_are_told():
    with pytest.raises(ValueError, match=r"no feature set 'papr'; choose from: paper, .*, all") as caught:
        feature_set("papr")
    assert "\n" not in str(caught.value)
