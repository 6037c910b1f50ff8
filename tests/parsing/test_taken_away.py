"""What is said of removals in a parse is what the judge says."""

from __future__ import annotations

from blockstab.parsing.taken_away import removal_of
from blockstab.scene.inference import Rules
from blockstab.stability.taking_apart import Reason
from blockstab.testing import worlds
from tests.box_scene import scene_of


def test_a_stack_falls_from_below_and_is_taken_from_above():
    found = removal_of(scene_of(*worlds.STACK), Rules())
    assert found.falls == {0: (1,), 1: ()}
    assert found.reasons == {(0, 1): Reason.SUPPORT}
    assert found.order == (1, 0)


def test_a_counterweight_is_told_from_a_support():
    found = removal_of(scene_of(*worlds.COUNTERWEIGHT), Rules())
    assert found.reasons[2, 1] == Reason.COUNTERWEIGHT
    assert found.reasons[0, 1] == Reason.SUPPORT
