import pytest

from blockstab.testing import worlds
from blockstab.testing.worlds import TABLE, judge
from tests.tolerance import EXACT


def test_a_block_on_the_table_stands_with_half_its_width_to_spare():
    verdict = judge(*worlds.ONE_BLOCK)
    assert verdict.balance.stable.tolist() == [True]
    assert verdict.supporters(0) == {TABLE}
    assert float(verdict.balance.margin[0]) == pytest.approx(0.05, abs=EXACT)


@pytest.mark.parametrize(("past", "stands"), [(-0.001, True), (0.001, False)])
def test_an_overhang_falls_one_millimetre_past_its_tipping_point_and_not_before(past, stands):
    verdict = judge(*worlds.overhang(past))
    assert verdict.balance.stable.tolist()[1] is stands
    assert float(verdict.balance.margin[1]) == pytest.approx(-past, abs=EXACT)


def test_a_beam_on_two_pillars_stands_but_the_rule_topples_its_pillars():
    # A departure from physics that is the paper's own: each pillar is loaded with the whole beam.
    verdict = judge(*worlds.BRIDGE)
    assert verdict.supporters(2) == {(0, "surface"), (1, "surface")}
    assert verdict.balance.stable.tolist() == [False, False, True]


def test_a_tower_that_is_fine_locally_falls_globally():
    verdict = judge(*worlds.FINE_LOCALLY_FALLS_GLOBALLY)
    assert verdict.balance.stable_alone.tolist() == [True, True, True]
    assert verdict.balance.stable.tolist() == [True, False, True]


def test_the_centre_of_mass_of_equal_blocks_is_the_middle_of_their_centres():
    verdict = judge(*worlds.FINE_LOCALLY_FALLS_GLOBALLY)
    expected = verdict.boxes.center.mean(dim=0)
    assert (verdict.balance.mass_center[0] - expected).abs().max() < EXACT


def test_a_box_with_nothing_under_it_is_unstable_and_has_no_margin():
    verdict = judge(worlds.Block(0, 0.5, 0.1, 0.1))
    assert verdict.balance.stable.tolist() == [False]
    assert verdict.balance.margin.isnan().all()


def test_background_stands_without_support():
    verdict = judge(worlds.Block(0, 0.5, 0.1, 0.1, fixed=True))
    assert verdict.balance.stable.tolist() == [True]


def test_a_counterweight_holds_up_the_overhang_below_it():
    stands = judge(*worlds.COUNTERWEIGHT).balance.stable
    without = judge(*worlds.COUNTERWEIGHT[:2]).balance.stable
    assert bool(stands.all())
    assert without.tolist()[1] is False
