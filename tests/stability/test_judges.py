"""What the machine code says of islands, against the steps that it puts together."""

from __future__ import annotations

import pytest
import torch

from blockstab.boxes.box import concatenate
from blockstab.boxes.separation import Separation, separation
from blockstab.stability.balance import Balance, balance
from blockstab.stability.judges import EverySupport, StabilityJudge, TrimmedSupports
from blockstab.stability.relating import related
from blockstab.stability.support import SupportRules, Supports, candidate_supports
from blockstab.stability.trimming import trim
from blockstab.testing import worlds
from blockstab.testing.worlds import Block, build, judge_boxes
from tests.stability.random_piles import KINDS, Table, table
from tests.tolerance import EXACT


def is_world(value: object) -> bool:
    return isinstance(value, tuple) and all(isinstance(part, Block) for part in value)


WORLDS = {
    **{name: world for name, world in vars(worlds).items() if is_world(world)},
    "overhang": worlds.overhang(0.0),
    "nothing beneath": (Block(0, 1.0, 0.1, 0.1),),
    "tilted on a corner": (Block(0, 0, 0.1, 0.1, tilt_deg=45.0),),
    "aligned tower": tuple(Block(0, 0.1 * k, 0.2, 0.1) for k in range(8)),
    "wall of bricks": tuple(
        Block(0.2 * i + 0.1 * (k % 2), 0.1 * k, 0.2, 0.1) for k in range(4) for i in range(5)
    ),
}
RULES, _RULE = SupportRules(), TrimmedSupports()


def judged(
    world: Table, slack: torch.Tensor, judge: StabilityJudge = _RULE
) -> tuple[Supports, Supports, Balance]:
    candidates = related(*world, RULES)
    return candidates, *judge(world.boxes, world.movable, candidates, slack)


def by_steps(world: Table, slack: torch.Tensor, trimming: bool = True) -> tuple[Supports, Supports, Balance]:
    candidates = candidate_supports(*world, RULES)
    supports = trim(world.boxes, candidates, slack) if trimming else candidates
    return candidates, supports, balance(world.boxes, world.movable, supports, slack)


def assert_same_supports(one: Supports, other: Supports) -> None:
    assert one.supporter.tolist() == other.supporter.tolist()
    assert one.supported.tolist() == other.supported.tolist()
    assert one.type.tolist() == other.type.tolist()
    assert one.area.count.tolist() == other.area.count.tolist()
    width = min(one.area.vertices.shape[1], other.area.vertices.shape[1])
    assert width >= int(one.area.count.max()) if len(one) else width
    assert (one.area.vertices[:, :width] - other.area.vertices[:, :width]).abs().amax(dim=(0, 1, 2)) < EXACT


def assert_same_verdicts(one: Balance, other: Balance) -> None:
    assert torch.equal(one.stable, other.stable)
    assert torch.equal(one.stable_alone, other.stable_alone)
    for field in ("margin", "mass_center", "support_center"):
        torch.testing.assert_close(
            getattr(one, field), getattr(other, field), rtol=0, atol=EXACT, equal_nan=True
        )


@pytest.mark.parametrize("name", WORLDS)
def test_machine_code_judges_a_small_world_as_the_steps_do(name):
    boxes, movable = build(*WORLDS[name])
    expected = judge_boxes(boxes, movable)
    n = len(boxes)
    exact, pairs = torch.zeros(n, dtype=torch.float64), tuple(torch.triu_indices(n, n, offset=1))
    apart = separation(boxes, *pairs)
    world = Table(boxes, pairs, apart, exact, movable, exact > 0)
    candidates, supports, verdicts = judged(world, exact)
    if len(expected.candidates):
        assert_same_supports(candidates, expected.candidates)
        assert_same_supports(supports, expected.supports)
    else:
        assert len(candidates) == len(supports) == 0
    assert_same_verdicts(verdicts, expected.balance)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("slack_m", [0.0, 0.01, None])
def test_machine_code_judges_random_piles_as_the_steps_do(kind, slack_m, generator):
    seen = 0
    while seen < 850:  # ten thousand islands in all
        world = table(kind, 170, 7, generator)
        n = len(world.boxes)
        slack = (
            RULES.noise(world.boxes) if slack_m is None else torch.full((n,), slack_m, dtype=torch.float64)
        )
        found, expected = judged(world, slack), by_steps(world, slack)
        assert_same_supports(found[0], expected[0])
        assert_same_supports(found[1], expected[1])
        assert_same_verdicts(found[2], expected[2])
        seen += 170


@pytest.mark.parametrize("kind", KINDS)
def test_machine_code_judges_large_piles_as_the_steps_do(kind, generator):
    world = table(kind, 12, 40, generator)
    slack = RULES.noise(world.boxes)
    found, expected = judged(world, slack), by_steps(world, slack)
    assert_same_supports(found[1], expected[1])
    assert_same_verdicts(found[2], expected[2])
    assert len(found[0]) > len(found[1]) > len(world.boxes) / 2


def test_without_trimming_every_candidate_counts(generator):
    world = table("in contact", 20, 8, generator)
    slack = RULES.noise(world.boxes)
    candidates, supports, verdicts = judged(world, slack, EverySupport())
    assert_same_supports(supports, candidates)
    assert_same_verdicts(verdicts, by_steps(world, slack, trimming=False)[2])


@pytest.mark.parametrize("kind", KINDS)
def test_a_pile_is_judged_alone_as_beside_others_to_the_bit(kind, generator):
    one, other = table(kind, 1, 8, generator), table(kind, 1, 8, generator)
    n = len(one.boxes)
    both = Table(
        concatenate([one.boxes, other.boxes]),
        tuple(torch.cat([a, b + n]) for a, b in zip(one.pairs, other.pairs, strict=True)),
        Separation(*(torch.cat(parts) for parts in zip(one.apart, other.apart, strict=True))),
        *(torch.cat(parts) for parts in zip(one[3:], other[3:], strict=True)),
    )
    alone = judged(one, RULES.noise(one.boxes))
    beside = judged(both, RULES.noise(both.boxes))
    assert torch.equal(beside[1].split([0, n, len(both.boxes)])[0].supporter, alone[1].supporter)
    for field in ("stable", "margin", "mass_center", "support_center"):
        assert torch.equal(
            getattr(beside[2], field)[:n].nan_to_num(-9), getattr(alone[2], field).nan_to_num(-9)
        )
