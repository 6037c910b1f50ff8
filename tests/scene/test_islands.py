"""Which objects can hold each other up, and tables of several such groups."""

from __future__ import annotations

import pytest
import torch

from blockstab.scene.islands import INTERACTION_M, Island, IslandTable, island_numbers, joined, overlaid
from blockstab.stability.balance import Balance
from blockstab.stability.support import GROUND
from blockstab.testing import worlds
from blockstab.testing.worlds import Block, build, judge


def numbers(*blocks: Block) -> list[int]:
    boxes, movable = build(*blocks)
    return island_numbers(boxes, ~movable, torch.zeros(len(boxes), dtype=torch.float64)).tolist()


@pytest.mark.parametrize(("gap", "together"), [(INTERACTION_M - 0.001, True), (INTERACTION_M + 0.001, False)])
def test_objects_within_reach_of_each_other_form_a_pile(gap, together):
    one, two = numbers(Block(0, 0, 0.1, 0.1), Block(0.1 + gap, 0, 0.1, 0.1))
    assert (one == two) == together


def test_objects_linked_by_others_form_a_pile():
    row = [Block(0.12 * k, 0, 0.1, 0.1) for k in range(6)]
    assert numbers(row[0], row[5], *row[1:5]) == [0] * 6


def test_an_object_high_above_another_is_in_its_pile():
    assert numbers(Block(0, 0, 0.1, 0.1), Block(0, 1.0, 0.1, 0.1)) == [0, 0]


def test_background_is_in_no_pile_and_links_none():
    table = Block(0, -0.1, 4.0, 0.1, d=4.0, fixed=True)
    assert numbers(Block(-1, 0, 0.1, 0.1), table, Block(1, 0, 0.1, 0.1)) == [0, -1, 2]


@pytest.mark.parametrize("blocks", [worlds.TENT, worlds.BRIDGE, worlds.COUNTERWEIGHT])
def test_what_holds_each_other_up_is_one_pile(blocks):
    assert numbers(*blocks) == [0] * len(blocks)


def test_a_table_of_piles_pairs_segments_within_a_pile_only():
    one, two, three, four, five, six = (frozenset({k}) for k in range(6))
    table = IslandTable.of([Island((one, four), (six,)), Island((two,), ()), Island((three, five), ())])
    assert table.segments == (one, four, six, two, three, five)
    assert table.movable.tolist() == [True, True, False, True, True, True]
    assert table.start == (0, 3, 4, 6)
    pairs = zip(table.first.tolist(), table.second.tolist(), strict=True)
    assert set(pairs) == {(0, 1), (0, 2), (1, 2), (4, 5)}


def test_relations_are_renamed_and_the_ground_stays_the_ground():
    supports = judge(*worlds.STACK).supports
    renamed = joined([supports], [[4, 7]])
    assert renamed.supporter.tolist() == [GROUND, 4]
    assert renamed.supported.tolist() == [4, 7]
    assert renamed.type.tolist() == supports.type.tolist()


def test_the_relations_of_piles_are_joined_under_the_names_of_the_scene():
    stack, counterweight = judge(*worlds.STACK).supports, judge(*worlds.COUNTERWEIGHT).supports
    whole = joined([stack, counterweight], [[4, 0], [3, 1, 2]])
    pairs = zip(whole.supporter.tolist(), whole.supported.tolist(), strict=True)
    assert list(pairs) == [(GROUND, 4), (4, 0), (GROUND, 3), (3, 1), (1, 2)]
    assert len(joined([], [])) == 0


def test_joining_takes_back_what_splitting_did():
    supports = judge(*worlds.STACK, Block(1.0, 0, 0.1, 0.1), Block(1.0, 0.1, 0.1, 0.1)).candidates
    parts = supports.split([0, 2, 4])
    assert [part.supported.tolist() for part in parts] == [[0, 1], [0, 1]]
    assert [part.supporter.tolist() for part in parts] == [[GROUND, 0], [GROUND, 0]]
    assert sorted(joined(parts, [[0, 1], [2, 3]]).supported.tolist()) == sorted(supports.supported.tolist())


def test_the_last_pile_says_what_rests_on_background_and_the_others_keep_their_verdicts():
    stack, weight = judge(*worlds.STACK).balance, judge(*worlds.COUNTERWEIGHT).balance
    scene = overlaid(
        Balance.of_background(torch.zeros(6, 3, dtype=torch.float64)), [stack, weight], [[2, 0], [5, 4, 0]]
    )
    assert scene.margin[[2, 0, 5, 4]].tolist() == [float(stack.margin[0]), *weight.margin[[2, 0, 1]].tolist()]
    assert scene.margin[[1, 3]].tolist() == [float("inf")] * 2
