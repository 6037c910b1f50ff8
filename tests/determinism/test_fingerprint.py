"""One word for what a result was made by: the same in every process, and another for anything else."""

from __future__ import annotations

import json
import sys
import threading
from collections import OrderedDict
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
import pytest
import torch
from torch import nn

from blockstab.boundaries.edge_models import LogisticWeights
from blockstab.boxes.fitting import MinimumSurface, PlaneTolerance
from blockstab.determinism.fingerprint import fingerprint
from blockstab.energy.paper import paper_energy
from blockstab.observation import given_ground
from blockstab.parsing.parser import Parser
from blockstab.proposals.files import LabelFile, MaskFile
from blockstab.proposals.pool import Regions
from blockstab.proposals.watershed import Watershed
from blockstab.scene.inference import Rules
from blockstab.search.moves.merge import Merge
from blockstab.search.moves.split import Split
from blockstab.search.moves.unexplained import Unexplained
from blockstab.search.none import NoSearch
from blockstab.search.rsamp import RSamp
from blockstab.stability.judges import EverySupport
from models.potentials.checkpoint import load_potentials, save_potentials
from models.stages.stages import load_stages, silberman
from tests.every_part import Noted, Plain, Sparing, doubled, fingerprints, in_another_process
from tests.toy_potentials import kinds_of, linear, toy_potentials

PARSER = Parser(LabelFile(), NoSearch(), toy_potentials())


def test_every_part_has_the_same_fingerprint_in_another_process_and_one_of_its_own():
    program = "import json; from tests.every_part import fingerprints; print(json.dumps(fingerprints()))"
    here = fingerprints()
    assert json.loads(in_another_process(program, seed=1)) == here
    assert len(set(here.values())) == len(here)


@pytest.mark.parametrize(
    ("one", "other"),
    [
        (PARSER, replace(PARSER, seed=1)),
        (PARSER, replace(PARSER, proposal=Watershed())),
        (PARSER, replace(PARSER, search=RSamp())),
        (PARSER, replace(PARSER, rules=Rules(judge=EverySupport()))),
        (PARSER, replace(PARSER, ground_of=given_ground)),
        (PARSER, replace(PARSER, energy=paper_energy)),
        (PARSER, replace(PARSER, pool=Regions((Watershed(),)))),
        (PARSER, replace(PARSER, potentials=replace(toy_potentials(), weight=0.2))),
        (RSamp(), RSamp(moves=(Split(), Merge()))),
        (RSamp((Split(), Merge())), RSamp((Merge(), Split()))),
        (Unexplained(), Unexplained(steps=4.0)),
        (PARSER, replace(PARSER, edges=LogisticWeights((0.0,) * 8, 1.0))),
        (Rules(), Rules(fitter=MinimumSurface(tolerance=PlaneTolerance(0.004)))),
        (Watershed(), Watershed(least_px=201)),
        (RSamp(), RSamp(rounds=21)),
        (MaskFile("a.json"), MaskFile("b.json")),
        (silberman(), silberman(order="random")),
        (load_stages("silberman"), replace(load_stages("silberman"), stages=())),
        (Plain(7), Plain(8)),
        (Sparing(1), Sparing(2)),
        (partial(doubled, 1), partial(doubled, 2)),
        (Plain, Noted),
        (doubled, fingerprints),
        (Plain(7).known, Plain(8).known),
        ([1, 2], [2, 1]),
        ([1, 2], (1, 2)),
        ([[1], 2], [1, [2]]),
        ({"a": 1}, {"a": 1.0}),
        ({"a", "b"}, {"a", "c"}),
        (OrderedDict(a=1), OrderedDict(a=2)),
        ("1", 1),
        (b"1", "1"),
        (True, 1),
        (0.0, -0.0),
        (Path("a"), "a"),
        (torch.zeros(2), torch.zeros(2, dtype=torch.float64)),
        (torch.zeros(2, 3), torch.zeros(3, 2)),
        (torch.zeros(2, dtype=torch.bfloat16), torch.ones(2, dtype=torch.bfloat16)),
        (np.zeros(2), np.ones(2)),
        (np.array([{"a": 1}]), np.array([{"a": 2}])),
        (nn.Dropout(0.1), nn.Dropout(0.2)),
    ],
    ids=lambda part: type(part).__name__,
)
def test_another_setting_gives_another_fingerprint(one, other):
    assert fingerprint(one) != fingerprint(other)
    assert fingerprint(one) == fingerprint(one)


@pytest.mark.parametrize(
    ("one", "other"),
    [
        (PARSER, Parser(LabelFile(), NoSearch(), toy_potentials())),
        (Noted(note="mine"), Noted(note="yours")),
        ({"a", "b", "c"}, {"c", "b", "a"}),
        (torch.arange(6).view(2, 3).T, torch.arange(6).view(2, 3).T.contiguous()),
        ([[1], [1]], [[1]] * 2),
    ],
    ids=["made twice", "a note", "a set", "strides", "one thing twice"],
)
def test_what_makes_no_difference_gives_the_same_fingerprint(one, other):
    assert fingerprint(one) == fingerprint(other)


def test_what_is_worked_out_on_the_way_makes_no_difference():
    part = Noted(3)
    before = fingerprint(part)
    assert part.doubled == 6
    assert fingerprint(part) == before


def saved(stem: Path, bias: float, provenance: dict[str, str]) -> Parser:
    toy = toy_potentials()
    unary = linear(toy.unary.columns, {}, bias)
    save_potentials(stem, kinds_of(toy, unary=unary), toy.weight, provenance)
    return replace(PARSER, potentials=load_potentials(stem))


def test_another_potential_file_gives_another_fingerprint_but_not_its_provenance(tmp_path):
    before = saved(tmp_path / "mine", 1.0, {"date": "today"}).fingerprint
    assert saved(tmp_path / "mine", 1.0, {"date": "tomorrow"}).fingerprint == before
    assert saved(tmp_path / "mine", 2.0, {"date": "today"}).fingerprint != before


@pytest.mark.parametrize(
    "reading",
    [
        lambda masks: {"proposal": masks},
        lambda masks: {"pool": Regions((Watershed(), masks))},
    ],
    ids=["proposal", "pool"],
)
def test_the_stamp_of_a_parser_is_that_of_the_files_its_parts_read(tmp_path, reading):
    parser = replace(PARSER, **reading(MaskFile(f"{tmp_path}/{{scene}}.json")))
    stamps = {parser.stamp("one")}
    for text in ("[]", "[1]"):
        (tmp_path / "one.json").write_text(text)
        stamps.add(parser.stamp("one"))
    assert len(stamps) == 3
    assert PARSER.stamp("one") == ""
    assert replace(PARSER, pool=Regions((Watershed(),))).stamp("one") == ""


class Holder:
    """Holds anything."""

    def __init__(self, thing: object) -> None:
        self.thing = thing


def made_inside() -> object:
    class Local:
        pass

    return Local()


@pytest.mark.parametrize(
    ("thing", "word"),
    [
        (lambda value: value, "<lambda>"),
        (made_inside(), "Local"),
        ((number for number in range(3)), "generator"),
        (threading.Lock(), "lock"),
        (sys.stdout, ""),
    ],
    ids=["lambda", "local class", "generator", "lock", "open file"],
)
def test_what_cannot_be_told_in_another_process_is_refused_in_one_line_that_names_it(thing, word):
    with pytest.raises(ValueError, match=r"Holder\.thing is or holds .*; (write|open) it") as refused:
        fingerprint([Holder(thing)])
    assert word in str(refused.value)
    assert "\n" not in str(refused.value)


def test_things_that_hold_each_other_are_told_apart():
    def ring(*sizes: int) -> Holder:
        holders = [Holder(None) for _ in sizes]
        for k, size in enumerate(sizes):
            holders[k].thing = (size, holders[(k + 1) % len(sizes)])
        return holders[0]

    assert fingerprint(ring(1, 2)) == fingerprint(ring(1, 2))
    assert len({fingerprint(ring(*sizes)) for sizes in ((1,), (1, 1), (1, 2), (2, 1))}) == 4


def test_a_thing_met_in_two_ways_is_described_once():
    tree: object = Holder(0)
    for _ in range(60):  # 2^60 ways lead to the leaf
        tree = Holder([tree, tree])
    fingerprint(tree)


def test_what_has_no_end_is_refused():
    holders = [Holder(None) for _ in range(20)]
    for holder in holders:
        holder.thing = list(holders)
    nested: list[object] = []
    for _ in range(20_000):
        nested = [nested]
    with pytest.raises(ValueError, match="too many things"):
        fingerprint(holders[0])
    with pytest.raises(ValueError, match="nested so deep"):
        fingerprint(nested)
