"""Predictions are made once for what they are made by; a run that was stopped goes on to the same result."""

from __future__ import annotations

import json
import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
import torch
from hydra.errors import InstantiationException
from omegaconf import DictConfig

import evaluate
from blockstab.determinism import fingerprint
from blockstab.features.columns import COLUMNS
from blockstab.testing.photographs import BLOCKS, photograph
from models.potentials.checkpoint import save_potentials
from tests.docs.pages import composed
from tests.synthetic import write_folder
from tests.tolerance import EXACT
from tests.toy_potentials import linear, toy_potentials

METHODS = {"start": "Start", "labels": "Labels"}  # and what the table calls them
EXPERIMENT = """\
defaults:
  - /method@methods.start: start
  - /method@methods.labels: support_surface
name: toy
scores: [overlap, stable_share]
methods: {labels: {name: Labels}}
"""


@pytest.fixture(autouse=True)
def threads() -> Iterator[None]:
    """Predicting takes one thread; the tests after it get theirs back."""
    before = torch.get_num_threads()
    yield
    torch.set_num_threads(before)


@pytest.fixture
def place(tmp_path: Path) -> Path:
    """Two scenes, potentials, and an experiment of two methods."""
    (tmp_path / "configs" / "experiment").mkdir(parents=True)
    (tmp_path / "configs" / "experiment" / "toy.yaml").write_text(EXPERIMENT)
    for k in range(2):
        write_folder(photograph(*BLOCKS[:2], seed=k).frame, tmp_path / "scenes" / f"scene{k}")
    saved(tmp_path, 1.0)
    return tmp_path


def saved(place: Path, bias: float) -> None:
    toy = toy_potentials()
    kinds = {kind: getattr(toy, kind) for kind in COLUMNS}
    save_potentials(place / "mine", {**kinds, "unary": linear(toy.unary.columns, {}, bias)}, toy.weight, {})


def configured(place: Path, *overrides: str) -> DictConfig:
    folders = [f"data.root={place}/scenes", f"out={place}/out", f"splits={place}/splits"]
    common = ["experiment=toy", "data=folder", f"potentials={place}/mine.json", "jobs=1", "pool=none"]
    return composed("evaluate", [*common, *folders, *overrides], place / "configs")


def evaluated(place: Path, *overrides: str) -> dict[str, int]:
    """Run, and say when each prediction was written."""
    evaluate.run(configured(place, *overrides))
    files = (place / "out" / "predictions").rglob("made.json")
    return {str(file.parent.relative_to(place / "out")): file.stat().st_mtime_ns for file in files}


def results(place: Path) -> dict[str, Any]:
    record = json.loads((place / "out" / "results.json").read_text())
    assert record.pop("seconds") >= 0
    return record


def redone(before: dict[str, int], after: dict[str, int]) -> set[str]:
    return {name for name, when in after.items() if before.get(name) != when}


def test_the_same_command_predicts_nothing_again_unless_told_to(place):
    first = evaluated(place)
    assert len(first) == 2 * len(METHODS)
    assert redone(first, evaluated(place)) == set()
    assert redone(first, evaluated(place, "overwrite=true")) == set(first)


def test_a_run_that_was_stopped_goes_on_to_the_same_result(place):
    first, whole = evaluated(place), results(place)
    labels = {name: (place / "out" / name / "labels.png").read_bytes() for name in first}
    stopped = "predictions/Labels/scene1"
    shutil.rmtree(place / "out" / stopped)
    (place / "out" / "results.json").unlink()
    assert redone(first, evaluated(place)) == {stopped}
    assert results(place) == whole
    assert {name: (place / "out" / name / "labels.png").read_bytes() for name in first} == labels


def test_a_changed_setting_of_one_method_predicts_that_one_again(place):
    first = evaluated(place)
    rules = "{_target_:blockstab.scene.inference.Rules,refit_rounds:0}"
    assert redone(first, evaluated(place, f"+experiment.methods.start.rules={rules}")) == {
        f"predictions/Start/scene{k}" for k in range(2)
    }


def test_changed_potentials_and_changed_code_predict_all_again(place, monkeypatch):
    first = evaluated(place)
    saved(place, 2.0)
    second = evaluated(place)
    assert redone(first, second) == set(first)
    monkeypatch.setattr(fingerprint, "own_sources", lambda: "a line more")
    assert redone(second, evaluated(place)) == set(first)


def test_a_row_tells_its_step_over_the_row_above(place):
    evaluated(place)
    above, row = results(place)["rows"]
    assert "step" not in above
    step = row["scores"]["overlap"] - above["scores"]["overlap"]
    assert step > 0
    assert row["step"]["overlap"] == pytest.approx(step, abs=EXACT)
    low, high = row["step_ci95"]["overlap"]
    assert low <= step + EXACT
    assert high >= step - EXACT


def test_methods_that_ask_for_the_same_share_it(place):
    one, two = (method.parser for method in evaluate.methods_of(configured(place)).values())
    assert one.edges is two.edges
    assert one.potentials is two.potentials
    assert one.pool is two.pool
    assert one.proposal != two.proposal


def test_a_method_may_have_potentials_of_its_own(place):
    toy = toy_potentials()
    save_potentials(place / "other", {kind: getattr(toy, kind) for kind in COLUMNS}, toy.weight, {})
    evaluated(place, f"+experiment.methods.labels.potentials={place}/other.json")
    assert [row["potential"] for row in results(place)["rows"]] == ["mine", "other"]


def test_a_misspelt_part_of_a_method_stops_the_run(place):
    with pytest.raises(ValueError, match="'serach'; a method has a name, scores and any of proposals"):
        evaluated(place, "+experiment.methods.labels.serach=greedy")
    assert not (place / "out").exists()


def test_a_search_can_be_followed_instead_of_scored(place):
    first = evaluated(place, "experiment.shows._target_=models.programs.evaluate.courses", "search=greedy")
    assert set(first) == set()
    rows = results(place)["rows"]
    for row in rows:
        assert list(row["scores"]) == ["overlap", "rank_correlation"]
        assert row["course"]["overlap"]["mean"][-1] == pytest.approx(row["scores"]["overlap"], abs=EXACT)
    files = {file: file.stat().st_mtime_ns for file in (place / "out" / "courses").rglob("course.json")}
    assert len(files) == 4
    evaluated(place, "experiment.shows._target_=models.programs.evaluate.courses", "search=greedy")
    assert files == {file: file.stat().st_mtime_ns for file in files}


def test_so_many_rows_are_made_as_are_named(place):
    assert set(evaluated(place, "methods=[labels]")) == {f"predictions/Labels/scene{k}" for k in range(2)}
    record = results(place)
    assert [row["method"] for row in record["rows"]] == ["Labels"]
    assert record["methods"] == ["labels"]
    with pytest.raises(ValueError, match="no method 'lables'; choose from: start, labels"):
        evaluated(place, "methods=[lables]")


def test_a_misspelt_maker_of_rows_stops_the_run(place):
    with pytest.raises(InstantiationException, match=r"Error locating target '.*evaluate.graphs'"):
        evaluated(place, "experiment.shows._target_=models.programs.evaluate.graphs")
    assert not (place / "out").exists()


def test_potentials_can_be_asked_about_segments_instead_of_searched_with(place):
    asked = [
        "experiment=potentials",
        f"+experiment.potentials.mine={place}/mine.json",
        "experiment.walks=2",
    ]
    assert set(evaluated(place, *asked)) == set()
    *shipped, row = results(place)["rows"]
    assert [one["method"] for one in shipped] == [one["potential"] for one in shipped] != []
    assert (row["method"], row["potential"]) == ("mine", "mine")
    assert 0.0 <= row["scores"]["auc"] <= 1.0
    assert row["ci95"]["auc"][0] <= row["scores"]["auc"] <= row["ci95"]["auc"][1]
    assert row["segments"] > 10


def test_potentials_are_chosen_by_name_as_methods_are(place):
    mine = ["experiment=potentials", f"+experiment.potentials.mine={place}/mine.json", "experiment.walks=1"]
    evaluated(place, *mine, "methods=[mine]")
    assert [row["method"] for row in results(place)["rows"]] == ["mine"]
