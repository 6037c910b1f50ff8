"""Eq. 2 by hand, and the fault of its printed form."""

from __future__ import annotations

import pytest

from blockstab.energy.paper import NEUTRAL, PaperEnergy
from blockstab.testing.worlds import Block
from tests.box_scene import scene_of
from tests.energy.described import described, first_column
from tests.tolerance import EXACT

ENERGY = PaperEnergy(first_column, first_column)
ROW = (Block(0, 0, 0.1, 0.1), Block(0.3, 0, 0.1, 0.1), Block(0.9, 0, 0.1, 0.1))


def test_energy_is_the_mean_over_segments_plus_the_mean_over_boundaries():
    one = described(scene_of(*ROW), [0.2, 0.9, 0.7], [0.3, 0.5, 0.1])
    (rating,) = ENERGY([one])
    assert rating.unary.tolist() == [0.2, 0.9, 0.7]
    assert float(rating.energy) == pytest.approx((0.2 + 0.9 + 0.7) / 3 + (0.3 + 0.5 + 0.1) / 3, abs=EXACT)
    assert rating.scene is one.scene


def test_background_takes_no_part_in_either_mean():
    table = Block(0, -0.1, 4.0, 0.1, d=4.0, fixed=True)
    with_table = described(scene_of(table, *ROW), [0.5, 0.2, 0.9, 0.7], [0.3, 0.5, 0.1])
    without = described(scene_of(*ROW), [0.2, 0.9, 0.7], [0.3, 0.5, 0.1])
    rated, bare = ENERGY([with_table, without])
    assert float(rated.energy) == pytest.approx(float(bare.energy), abs=EXACT)
    assert len(rated.unary) == 4  # but it is rated


@pytest.mark.parametrize(("fixed", "energy"), [(False, 0.75 + NEUTRAL), (True, NEUTRAL + NEUTRAL)])
def test_a_mean_over_nothing_is_neither_good_nor_bad(fixed, energy):
    (rating,) = ENERGY([described(scene_of(Block(0, 0, 0.1, 0.1, fixed=fixed)), [0.75])])
    assert float(rating.energy) == energy


def test_no_scene_has_no_rating():
    assert ENERGY([]) == []


def test_merging_two_bad_segments_lowers_the_printed_energy_though_nothing_is_better():
    # One good segment and two bad ones; then the bad ones are one, as bad as they were.
    before = described(scene_of(*ROW), [0.0, 1.0, 1.0], [1.0, 1.0, 1.0])
    after = described(scene_of(*ROW[:2]), [0.0, 1.0], [1.0])
    apart, merged = ENERGY([before, after])
    assert float(merged.energy) < float(apart.energy)


def test_cutting_a_good_segment_in_two_good_ones_lowers_the_printed_energy_beside_a_bad_one():
    before = described(scene_of(*ROW[:2]), [0.0, 1.0], [1.0])
    after = described(scene_of(*ROW), [0.0, 0.0, 1.0], [1.0, 1.0, 1.0])
    whole, cut = ENERGY([before, after])
    assert float(cut.energy) < float(whole.energy)
