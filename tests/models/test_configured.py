"""Configurations become parsers."""

from __future__ import annotations

from dataclasses import fields

import pytest
from omegaconf.errors import ConfigAttributeError

from blockstab.parsing.parser import Parser
from models import configured
from models.configured import PARTS, ParserMaker, composed
from models.potentials.heads import LinearHead
from tests.toy_potentials import toy_potentials

PLAIN = {"potentials": "toy"}


@pytest.fixture(autouse=True)
def toy(monkeypatch):
    """Potentials of any name, that say which heads they may have."""
    asked = []
    monkeypatch.setattr(
        configured,
        "parsing_potentials",
        lambda path, heads, columns: asked.append((path, heads)) or toy_potentials(),
    )
    return asked


def test_every_part_of_a_parser_is_a_key_and_every_key_a_part():
    assert set(PARTS.values()) | {"columns"} == {field.name for field in fields(Parser)}
    # Of the rules, of potentials, of the parser beside its parts, and where it runs.
    assert set(composed("parse", [], {})) - set(PARTS) == {"judge", "heads", "columns", "executor"}


def test_the_configuration_of_a_parse_is_the_parser_that_code_makes():
    made = ParserMaker()(composed("parse", [], PLAIN))
    by_code = Parser(made.proposal, made.search, made.potentials)
    assert made.rules == by_code.rules
    assert made.edges == by_code.edges
    assert made.ground_of is by_code.ground_of
    assert made.seed == by_code.seed
    assert tuple(made.pool.proposals) == tuple(by_code.pool.proposals)
    assert made.energy.keywords == {"caution": 0.1, "turning": 0.3}


def test_values_are_taken_word_for_word():
    odd = "a=b, {scene}/[1] it's.json"
    assert composed("parse", ["proposals=files"], {"proposals.path": odd}).proposals.path == odd
    with pytest.raises(ConfigAttributeError):
        composed("parse", [], {"proposals.paths": odd})


def test_parts_that_are_configured_alike_are_one(toy):
    maker, cfg = ParserMaker(), composed("parse", [], PLAIN)
    one, other = (
        maker(cfg),
        maker(cfg, {"search": composed("parse", ["search=greedy"], {}).search, "seed": 3}),
    )
    assert one.pool is other.pool
    assert one.potentials is other.potentials
    assert len(toy) == 1
    assert type(one.search) is not type(other.search)
    assert (one.seed, other.seed) == (0, 3)


def test_potentials_may_name_our_heads_and_those_that_are_told(toy):
    ParserMaker(["models.potentials.heads.LinearHead"]).potentials("mine")
    ((path, heads),) = toy
    assert path == "mine"
    assert heads["linear"] is LinearHead
    assert {"linear", "mlp", "trees"} <= set(heads)


def test_configurations_of_ones_own_are_found_beside_ours(tmp_path):
    (tmp_path / "search").mkdir()
    (tmp_path / "search" / "mine.yaml").write_text("_target_: blockstab.search.greedy.Greedy\n")
    cfg = composed("parse", ["search=mine"], {}, tmp_path)
    assert cfg.search._target_ == "blockstab.search.greedy.Greedy"
