"""Results of folds, put together."""

from __future__ import annotations

import json
import subprocess
import sys
from importlib import util
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

from tests.docs.pages import DOCS, ROOT

SCRIPT = DOCS / "pool.py"


@pytest.fixture(scope="module")
def pooling() -> ModuleType:
    spec = util.spec_from_file_location("pool", SCRIPT)
    assert spec is not None
    assert spec.loader is not None
    module = util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def fold(number: int, scenes: dict[str, float], score: str = "overlap") -> dict[str, Any]:
    row = {
        "method": "Watershed",
        "potential": "mlp",
        "scores": {score: sum(scenes.values()) / len(scenes)},
        "ci95": {score: [0.0, 1.0]},
        "per_image": {scene: {score: value} for scene, value in scenes.items()},
    }
    data = {"name": "osd", "split": "folds", "part": f"test{number}", "images": len(scenes), "left_out": []}
    return {"experiment": "proposals", "data": data, "rows": [row], "seed": 0, "seconds": 2.0, "versions": {}}


def test_every_image_counts_once_whatever_the_size_of_its_fold(pooling: ModuleType) -> None:
    found = pooling.pool([fold(0, {"a": 0.9, "b": 0.6, "c": 0.6}), fold(1, {"d": 0.1})])
    (row,) = found["rows"]
    assert row["scores"]["overlap"] == pytest.approx(0.55)
    assert set(row["per_image"]) == {"a", "b", "c", "d"}
    low, high = row["ci95"]["overlap"]
    assert 0.1 <= low < 0.55 < high <= 0.9
    assert found["data"]["images"] == 4
    assert found["data"]["part"] == "test0+test1"
    assert found["seconds"] == 4.0


def test_an_image_that_a_score_does_not_concern_does_not_count(pooling: ModuleType) -> None:
    one = fold(0, {"a": 0.5, "b": 0.7})
    del one["rows"][0]["per_image"]["b"]["overlap"]
    assert pooling.pool([one, fold(1, {"c": 0.9})])["rows"][0]["scores"]["overlap"] == pytest.approx(0.7)


@pytest.mark.parametrize(
    ("other", "said"),
    [
        (fold(1, {"a": 0.5}), "no scene in common"),
        (fold(1, {"b": 0.5}, "stable_share"), "same methods and scores"),
        ({**fold(1, {"b": 0.5}), "seed": 1}, "must agree in experiment, seed"),
    ],
)
def test_what_does_not_fit_together_is_refused(pooling: ModuleType, other: dict[str, Any], said: str) -> None:
    with pytest.raises(ValueError, match=said):
        pooling.pool([fold(0, {"a": 0.5}), other])


def test_scores_over_objects_cannot_be_pooled_from_means_of_images(pooling: ModuleType) -> None:
    with pytest.raises(ValueError, match="over objects cannot be pooled"):
        pooling.pool([fold(n, {str(n): 0.5}, "stable_share") for n in range(2)])


def test_the_command_writes_one_file_and_says_in_one_line_what_is_wrong(tmp_path: Path) -> None:
    for number in range(2):
        (tmp_path / f"{number}.json").write_text(json.dumps(fold(number, {str(number): 0.5})))
    files = [str(tmp_path / f"{number}.json") for number in range(2)]

    def run(*words: str) -> subprocess.CompletedProcess[str]:
        command = [sys.executable, str(SCRIPT), *words, "--out", str(tmp_path / "all.json")]
        return subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)

    assert run(*files).returncode == 0
    assert json.loads((tmp_path / "all.json").read_text())["data"]["images"] == 2
    refused = run(files[0], files[0])
    assert refused.returncode == 1
    assert len(refused.stderr.splitlines()) == 1
