"""Orders in which nothing falls, and reasons for what does, worked out by hand."""

from __future__ import annotations

from itertools import pairwise

import pytest
import torch

from blockstab.stability.judges import StabilityJudge, StaticEquilibrium, TrimmedSupports
from blockstab.stability.removal import falls_if_removed
from blockstab.stability.taking_apart import Reason, reasons, removal_order
from blockstab.testing.worlds import BRIDGE, COUNTERWEIGHT, STACK, Block, build
from tests.stability.touching import relations

JUDGES = [TrimmedSupports(), StaticEquilibrium(angle_deg=1.0)]
each_judge = pytest.mark.parametrize("judge", JUDGES, ids=lambda judge: type(judge).__name__)
Asked = tuple[torch.Tensor, tuple[int, ...] | None, dict[tuple[int, int], Reason]]


def asked(world: tuple[Block, ...], judge: StabilityJudge) -> Asked:
    """What falls without each, an order, and why."""
    boxes, movable = build(*world)
    candidates, exact = relations(boxes, movable), torch.zeros(len(boxes), dtype=torch.float64)
    supports, balance = judge(boxes, movable, candidates, exact)
    scene = boxes, movable, candidates, balance.stable, exact, judge
    falls = falls_if_removed(*scene)
    return falls, removal_order(*scene), reasons(supports, falls)


@each_judge
def test_a_stack_goes_from_its_top(judge):
    falls, order, why = asked((*STACK, Block(0, 0.2, 0.2, 0.1)), judge)
    assert order == (2, 1, 0)
    assert why == dict.fromkeys([(0, 1), (0, 2), (1, 2)], Reason.SUPPORT)
    assert falls.sum() == 3


@each_judge
def test_a_bridge_goes_before_its_pillars_and_one_island_after_the_other(judge):
    _, order, _ = asked((*BRIDGE, Block(1.0, 0, 0.1, 0.1), Block(1.0, 0.1, 0.1, 0.1)), judge)
    assert order == (2, 0, 1, 4, 3)


@each_judge
def test_a_counterweight_and_what_it_holds_have_no_order(judge):
    _, order, why = asked(COUNTERWEIGHT, judge)
    assert order is None
    assert why[2, 1] is Reason.COUNTERWEIGHT
    assert why[1, 2] is why[0, 1] is why[0, 2] is Reason.SUPPORT


def test_background_is_never_taken_and_what_falls_as_it_is_hinders_nothing():
    world = (Block(0, 0, 0.4, 0.1, fixed=True), Block(0, 0.1, 0.1, 0.1), Block(1.0, 0.5, 0.1, 0.1))
    _, order, why = asked(world, JUDGES[1])
    assert order is not None
    assert set(order) == {1, 2}
    assert why == {}


@each_judge
def test_in_a_random_wall_each_step_of_the_order_lets_nothing_fall(judge, generator):
    wall = tuple(Block(0.2 * i + 0.1 * (k % 2), 0.1 * k, 0.2, 0.1) for k in range(3) for i in range(3))
    boxes, movable = build(*wall)
    exact = torch.zeros(len(boxes), dtype=torch.float64)
    _, order, _ = asked(wall, judge)
    assert order is not None
    assert sorted(order) == list(range(9))
    for done in range(len(order)):
        left = sorted(order[done:])
        part = boxes[torch.tensor(left)]
        verdicts = judge(part, movable[left], relations(part, movable[left]), exact[left])
        assert bool(verdicts.balance.stable.all())
    assert all(boxes.center[a, 1] >= boxes.center[b, 1] for a, b in pairwise(order))
