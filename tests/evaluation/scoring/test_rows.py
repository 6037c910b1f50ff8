"""Rows of a table, from what methods scored."""

from __future__ import annotations

import pytest

from blockstab.evaluation.scoring import Score
from blockstab.evaluation.scoring.rows import Scored, rows_of
from tests.tolerance import EXACT


def scored(method: str, *values: float, name: str = "overlap") -> Scored:
    return Scored(method, "mlp", (name,), {str(k): {name: Score(v, 1)} for k, v in enumerate(values)})


def test_a_row_tells_its_step_over_the_row_above():
    first, second = rows_of([scored("Start", 0.2, 0.4), scored("R-Samp", 0.3, 0.5)], seed=0)
    assert "step" not in first
    assert second["scores"]["overlap"] == pytest.approx(0.4, abs=EXACT)
    assert second["step"]["overlap"] == pytest.approx(0.1, abs=EXACT)
    assert second["step_ci95"]["overlap"] == pytest.approx([0.1, 0.1], abs=EXACT)
    assert second["per_image"] == {"0": {"overlap": 0.3}, "1": {"overlap": 0.5}}


def test_there_is_no_step_between_rows_with_other_scores():
    rows = rows_of([scored("Start", 0.2), scored("Neighbour", 1.0, name="stable_share")], seed=0)
    assert all("step" not in row for row in rows)


def test_where_nothing_was_scored_there_is_null():
    empty = Scored("Start", "mlp", ("overlap",), {"0": {"overlap": Score(0.0, 0)}})
    first, second = rows_of([empty, empty], seed=0)
    assert first["scores"] == first["ci95"] == {"overlap": None}
    assert first["per_image"] == {"0": {}}
    assert second["step"] == second["step_ci95"] == {"overlap": None}
