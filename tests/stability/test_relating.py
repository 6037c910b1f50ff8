"""The relations of machine code, against those of the steps in torch."""

from __future__ import annotations

import pytest

from blockstab.stability.relating import related
from blockstab.stability.support import SupportRules, candidate_supports
from tests.stability.random_piles import KINDS, table
from tests.stability.test_judges import assert_same_supports

RULES = SupportRules()


@pytest.mark.parametrize("kind", KINDS)
def test_machine_code_relates_boxes_as_the_steps_do(kind, generator):
    for amount, largest in ((40, 7), (4, 30)):
        world = table(kind, amount, largest, generator)
        assert_same_supports(related(*world, RULES), candidate_supports(*world, RULES))


def test_other_rules_find_other_relations(generator):
    world = table("in contact", 20, 8, generator)
    near, far = (related(*world, SupportRules(touch_m=touch)) for touch in (0.001, 0.2))
    assert len(near) < len(far)
