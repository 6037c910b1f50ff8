"""Potentials pick their columns, by name, out of all that a parse computes."""

from __future__ import annotations

import pytest
import torch

from blockstab.features.columns import COLUMNS
from models.potentials.checkpoint import save_potentials
from models.potentials.parsing import choosing, parsing_potentials
from models.potentials.record import CheckpointError
from tests.toy_potentials import kinds_of, linear, toy_potentials

SOME = ("pixels_log", "stable", "outline_depth")  # not in the order in which they are computed
POTENTIAL = linear(SOME, {"pixels_log": 1.0, "stable": 10.0, "outline_depth": 100.0}, 0.0)


def test_a_potential_of_some_columns_sees_those_and_no_others(generator):
    rows = torch.rand(5, len(COLUMNS["unary"]), generator=generator, dtype=torch.float64)
    chosen = choosing(toy_potentials())
    picked = torch.stack([rows[:, COLUMNS["unary"].index(name)] for name in SOME], dim=1)
    for given in (rows, rows.float()):
        mine = choosing(_with(unary=POTENTIAL)).unary
        torch.testing.assert_close(mine(given), POTENTIAL(picked.to(given.dtype)))
        torch.testing.assert_close(mine.badness(given), POTENTIAL.badness(picked.to(given.dtype)))
    assert torch.equal(chosen.unary(rows), toy_potentials().unary(rows))


def test_name_digest_and_weight_come_along(tmp_path):
    save_potentials(tmp_path / "mine", kinds_of(toy_potentials(), unary=POTENTIAL), 0.25, {})
    loaded = parsing_potentials(tmp_path / "mine")
    assert (loaded.name, loaded.weight, len(loaded.sha256)) == ("mine", 0.25, 64)
    assert {kind: getattr(loaded, kind).potential.columns for kind in COLUMNS} == {**COLUMNS, "unary": SOME}


@pytest.mark.parametrize("kind", COLUMNS)
def test_a_column_that_is_not_computed_is_one_clear_error(kind, tmp_path):
    odd = linear(("stable_by_night",), {}, 0.0)
    save_potentials(tmp_path / "mine", kinds_of(toy_potentials(), **{kind: odd}), 0.0, {})
    with pytest.raises(CheckpointError, match="needs the column 'stable_by_night'") as caught:
        parsing_potentials(tmp_path / "mine")
    assert "\n" not in str(caught.value)


def _with(**changed):
    toy = toy_potentials()
    return type(toy)(**kinds_of(toy, **changed), weight=0.0, name="", sha256="", provenance={})
