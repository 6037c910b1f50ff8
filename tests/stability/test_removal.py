import torch

from blockstab.stability.removal import falls_if_removed
from blockstab.testing import worlds
from blockstab.testing.worlds import judge


def falls(*blocks: worlds.Block) -> list[list[int]]:
    verdict = judge(*blocks)
    exact = torch.zeros(len(blocks), dtype=torch.float64)
    table = falls_if_removed(
        verdict.boxes, verdict.movable, verdict.candidates, verdict.balance.stable, exact
    )
    return [row.nonzero()[:, 0].tolist() for row in table]


def test_what_stands_on_a_removed_block_falls_and_nothing_else():
    assert falls(*worlds.STACK) == [[1], []]


def test_everything_above_a_removed_block_falls_not_only_its_neighbour():
    tower = tuple(worlds.Block(0, 0.1 * k, 0.2, 0.1) for k in range(4))
    assert falls(*tower) == [[1, 2, 3], [2, 3], [3], []]


def test_removing_a_counterweight_topples_what_lies_below_it():
    assert falls(*worlds.COUNTERWEIGHT)[2] == [1]


def test_either_plank_of_a_tent_falls_without_the_other():
    assert falls(*worlds.TENT) == [[1], [0]]


def test_a_plank_falls_only_with_what_it_leans_on_and_background_is_never_removed():
    assert falls(*worlds.LEANING_PLANK) == [[], []]


def test_a_neighbour_that_holds_nothing_up_can_go():
    assert falls(*worlds.TOUCHING_NEIGHBOURS) == [[], []]
