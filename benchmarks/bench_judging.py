"""Relations, trimming and verdicts of islands: machine code beside the steps in torch that it puts together."""

from __future__ import annotations

import pytest
import torch
from pytest_benchmark.fixture import BenchmarkFixture
from torch import Tensor

from blockstab.commands.warm_up import warm_up
from blockstab.stability.balance import balance
from blockstab.stability.judges import TrimmedSupports
from blockstab.stability.relating import related
from blockstab.stability.support import SupportRules, candidate_supports
from blockstab.stability.trimming import trim
from tests.stability.random_piles import Table, table

RULES = SupportRules()


def islands(amount: int, largest: int) -> tuple[Table, Tensor]:
    world = table("any", amount, largest, torch.Generator().manual_seed(amount))
    return world, RULES.noise(world.boxes)


def by_steps(world: Table, slack: Tensor) -> None:
    candidates = candidate_supports(*world, RULES)
    balance(world.boxes, world.movable, trim(world.boxes, candidates, slack), slack)


@pytest.mark.parametrize(("amount", "largest"), [(1, 10), (1, 40), (50, 10)])
class TestPiles:
    @pytest.fixture(autouse=True)
    def beside_the_same_piles(self, benchmark: BenchmarkFixture, amount: int, largest: int) -> None:
        benchmark.group = f"{amount} islands of up to {largest} boxes"

    def test_machine_code(self, benchmark: BenchmarkFixture, amount: int, largest: int) -> None:
        warm_up()
        world, slack = islands(amount, largest)
        judge = TrimmedSupports()
        benchmark(lambda: judge(world.boxes, world.movable, related(*world, RULES), slack))

    def test_steps(self, benchmark: BenchmarkFixture, amount: int, largest: int) -> None:
        world, slack = islands(amount, largest)
        benchmark(lambda: by_steps(world, slack))
