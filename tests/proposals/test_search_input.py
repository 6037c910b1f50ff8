"""An image made ready: regions as sets of atoms, and what the proposal told of them."""

from __future__ import annotations

from dataclasses import dataclass, field

import pytest
import torch
from torch import Tensor

from blockstab.observation import Observation
from blockstab.proposals import Proposed
from blockstab.proposals.search_input import SearchInput, make_search_input
from tests.search.watched import blocks_view


@dataclass(frozen=True)
class Drawn:
    """A proposal that was drawn by hand, and what it knows."""

    label: Tensor
    known: dict[int, bool] = field(default_factory=dict)

    def __call__(self, observation: Observation) -> Proposed:
        return Proposed(self.label, self.known)


def label() -> Tensor:
    found = blocks_view().observation.frame.label
    assert found is not None
    return found


def made(known: dict[int, bool] | None = None, shown: Tensor | None = None) -> SearchInput:
    return make_search_input(
        blocks_view().observation, Drawn(label() if shown is None else shown, known or {})
    )


def told_by_id(search_input: SearchInput) -> dict[int, bool]:
    """What is told of each region, by the id that the proposal gave it."""
    ids = {
        s: int(search_input.label[search_input.atoms.label == min(s) + 1][0])
        for s in search_input.start.segments
    }
    return {ids[segment]: told for segment, told in search_input.start.background.items()}


@pytest.mark.parametrize("known", [{}, {1: True}, {1: True, 3: False, 5: True}])
def test_the_start_tells_what_the_proposal_knows_and_nothing_else(known):
    assert told_by_id(made(known)) == known


def test_what_is_known_of_ids_that_have_no_region_is_told_of_nothing():
    assert told_by_id(made({1: True, 77: False})) == {1: True}


def test_ids_carry_no_order_for_what_is_told():
    ids = torch.tensor([0, 40, 7, 300, 2, 9])
    assert told_by_id(made({40: True, 9: False}, ids[label()])) == {40: True, 9: False}


def test_what_the_proposal_leaves_out_is_in_no_atom():
    search_input = made(shown=torch.where(label() == 3, 0, label()))
    assert not bool(search_input.atoms.label[label() == 3].any())
    assert len(search_input.start) == 4


def test_nothing_but_the_proposal_decides_where_to_start():
    one, other = made({1: True}), made({1: True})
    assert one.start == other.start
    assert torch.equal(one.atoms.label, other.atoms.label)
