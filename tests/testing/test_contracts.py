"""The contracts that plug-ins can be tested by: ours keep to them, and one that does not is found out."""

from __future__ import annotations

from dataclasses import dataclass

import pytest
import torch

from blockstab import testing
from blockstab.datasets.folder import write_scene
from blockstab.datasets.sets import FolderScenes
from blockstab.datasets.truth import Truth
from blockstab.energy.overlap import expected_overlap
from blockstab.energy.paper import paper_energy
from blockstab.proposals import Proposed
from blockstab.proposals.watershed import Watershed
from blockstab.search.greedy import Greedy
from blockstab.search.moves.every import EVERY
from blockstab.search.none import NoSearch
from blockstab.search.rsamp import RSamp
from blockstab.simulation.sensors import SENSORS
from blockstab.stability.balance import balance
from blockstab.stability.judges import StaticEquilibrium, TrimmedSupports, Verdicts
from blockstab.testing.photographs import BLOCKS, photograph
from tests.own_columns import Height


def of(contract: type, part: object) -> type:
    """The contract of a part, as its author would write it."""
    return type("TestPart", (contract,), {"part": part})


def broken(contract: type, part: object) -> set[str]:
    """The names of the tests that a part does not pass."""
    found, tests = set(), of(contract, part)()
    for name in dir(tests):
        if name.startswith("test_"):
            try:
                getattr(tests, name)()
            except (AssertionError, ValueError):
                found.add(name)
    return found


@pytest.mark.parametrize("move", EVERY, ids=lambda move: type(move).__name__)
def test_our_moves_keep_their_contract(move):
    assert broken(testing.MoveContract, move) == set()


@pytest.mark.parametrize("search", [NoSearch(), Greedy(), RSamp(rounds=1)], ids=lambda s: type(s).__name__)
def test_our_searches_keep_their_contract(search):
    assert broken(testing.SearchContract, search) == set()


@pytest.mark.parametrize("energy", [expected_overlap, paper_energy], ids=lambda e: e.__name__)
def test_our_energies_keep_their_contract(energy):
    assert broken(testing.EnergyContract, energy) == set()


@pytest.mark.parametrize("name", SENSORS)
def test_our_sensors_keep_their_contract(name):
    assert broken(testing.SensorContract, SENSORS[name]) == set()


def test_our_judge_our_proposal_and_our_folders_keep_their_contracts(tmp_path):
    write_scene(tmp_path / "a", photograph(*BLOCKS).frame, Truth((1,), (), None, False), {})
    assert broken(testing.JudgeContract, TrimmedSupports()) == set()
    assert broken(testing.JudgeContract, StaticEquilibrium()) == set()
    assert broken(testing.ProposalContract, Watershed()) == set()
    assert broken(testing.SceneSetContract, FolderScenes(tmp_path)) == set()


@dataclass(frozen=True)
class Restless:
    """A move that draws from the generator of all, and a proposal that does not know what it wants."""

    def __call__(self, *given):
        if len(given) == 1:
            label = torch.randint(1, 3, given[0].frame.depth.shape)
            return Proposed(label, {7: True})
        rating, _, _, _ = given
        torch.rand(1)
        return [rating.scene.segmentation]


@dataclass(frozen=True)
class Moody:
    """A column that says something else each time, under a name that is taken."""

    columns = ("stable",)

    def __call__(self, observation, atoms, scene):
        return torch.rand(len(scene), 1)


@dataclass(frozen=True)
class Optimist:
    """A judge to which everything stands."""

    def __call__(self, boxes, movable, candidates, slack):
        said = balance(boxes, movable & False, candidates, slack)
        return Verdicts(candidates, said)


def test_a_move_that_breaks_its_contract_is_found_out():
    assert {
        "test_every_result_differs_from_where_it_started",
        "test_it_draws_from_its_generator_alone",
    } <= broken(testing.MoveContract, Restless())


def test_a_proposal_that_breaks_its_contract_is_found_out():
    assert {
        "test_the_same_picture_gives_the_same_regions",
        "test_what_is_known_is_known_of_regions_that_exist",
    } <= broken(testing.ProposalContract, Restless())


def test_a_judge_that_breaks_its_contract_is_found_out():
    assert {
        "test_a_block_in_the_air_falls_unless_it_is_background",
        "test_what_stands_on_a_block_falls_without_it",
    } <= broken(testing.JudgeContract, Optimist())


def test_our_column_of_tests_keeps_its_contract_and_one_that_breaks_it_is_found_out():
    assert broken(testing.ColumnsContract, Height()) == set()
    assert {"test_asked_twice_it_says_the_same"} <= broken(testing.ColumnsContract, Moody())
    with pytest.raises(ValueError, match="stable came twice"):
        of(testing.ColumnsContract, Moody())().test_its_columns_have_names_of_their_own()
