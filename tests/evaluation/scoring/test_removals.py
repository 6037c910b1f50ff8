"""A search in the graph of supports finds all that rests on a thing, and not the thing itself."""

from __future__ import annotations

from blockstab.evaluation.scoring.removals import reached


def test_all_that_rests_on_a_thing_is_reached():
    assert reached(1, [(1, 2), (2, 3), (4, 3)]) == {2, 3}
    assert reached(3, [(1, 2), (2, 3), (4, 3)]) == set()


def test_things_that_lean_on_each_other_do_not_reach_themselves():
    assert reached(1, [(1, 2), (2, 1), (2, 3)]) == {2, 3}
