"""The tables of docs/results.md and README.md are those of the stored results."""

from __future__ import annotations

import json
import subprocess
import sys
from importlib import util
from types import ModuleType

import pytest

from tests.docs.pages import DOCS, ROOT

SCRIPT = DOCS / "tables.py"


@pytest.fixture
def tables() -> ModuleType:
    spec = util.spec_from_file_location("tables", SCRIPT)
    assert spec is not None
    assert spec.loader is not None
    module = util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def results(name: str, **scores: float | None) -> dict:
    ci95 = {
        score: value if value is None else [value - 0.01, value + 0.01] for score, value in scores.items()
    }
    row = {"method": "R-Samp", "potential": "mlp", "scores": scores, "ci95": ci95, "per_image": {}}
    data = {"name": name, "images": 8}
    return {
        "experiment": "blocks", "data": data, "rows": [row], "seed": 3, "seconds": 1.0, "versions": {"torch": "2"}
    }  # fmt: skip


def test_the_page_is_up_to_date():
    command = [sys.executable, str(SCRIPT), "--check"]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr


def test_a_page_with_another_table_is_out_of_date(tables, tmp_path, monkeypatch):
    page = tmp_path / "results.md"
    monkeypatch.setattr(tables, "PAGES", {page: ("*.json", tables.tables)})
    monkeypatch.setattr(tables, "RESULTS", tmp_path)
    page.write_text(f"before\n{tables.START}old{tables.END}\nafter\n")
    (tmp_path / "some.json").write_text(json.dumps(results("osd", overlap=0.9)))
    assert tables.main(check=True) == 1
    assert tables.main(check=False) == 0
    assert tables.main(check=True) == 0
    text = page.read_text()
    assert text.startswith("before\n")
    assert text.endswith("\nafter\n")
    assert "90.0 % [89.0, 91.0]" in text


def test_without_results_the_page_says_so(tables):
    assert tables.tables([]) == tables.NONE


def test_a_table_tells_its_command_its_scores_and_the_papers(tables, tmp_path):
    file = tmp_path / "blocks_small.json"
    file.write_text(
        json.dumps(
            results("blocks_8_seed5_kinect_variety1", axis_error_deg=2.5, overlap=0.75, stable_share=None)
        )
    )
    text = tables.tables([file])
    assert "## blocks_small" in text
    data = "data=simulated data.preset=blocks data.count=8 data.seed=5 data.sensor=kinect data.variety=1"
    assert f"{data} potentials=mlp seed=3" in text
    assert "| method | axis_error_deg | overlap | overlap in the paper | stable_share |" in text
    assert "| R-Samp | 2.50° [2.49, 2.51] | 75.0 % [74.0, 76.0] | 70.0 % (SOD), 72.3 % (GD)" in text
    assert "|  |" in text


def test_the_census_of_a_set_stands_beside_the_command_that_made_it(tables, tmp_path):
    counts = {"scenes": 50, "objects": 383, "fewest": 3, "most": 14, "on_objects": 0.564, "felling": 1.0}
    (tmp_path / "blocks_50_seed7.json").write_text(json.dumps(counts))
    text = tables.census([tmp_path / "blocks_50_seed7.json"])
    assert "| `--preset blocks --count 50 --seed 7` | 50 | 383 | 3 to 14 | 56 % | 100 % |" in text


def test_speed_has_a_line_for_each_run_and_each_number_of_objects(tables, tmp_path):
    stages = {"before the search": [0.5, 0.7], "search": [1.25, 3.0]}
    run = {
        "set": "osd",
        "scenes": 51,
        "code": "now",
        "jobs": 2,
        "stages": stages,
        "wall_s": 99.6,
        "peak_mib": 812,
    }
    step = {
        "cubes": "near",
        "gap_m": 0.01,
        "objects": 80,
        "milliseconds": 41.4,
        "fits": 2,
        "gaps": 157,
        "verdicts": 158,
    }
    for name, row in (("whole_images", run), ("step_cost", step)):
        (tmp_path / f"{name}.json").write_text(json.dumps({"rows": [row]}))
    text = tables.speed(sorted(tmp_path.glob("*.json")))
    assert "| osd (51) | now | 2 | 0.50, 0.70 s | 1.25, 3.00 s | 100 s | 812 MiB |" in text
    assert "| near, 1.0 cm | 80 | 41 ms | 2 | 157 | 158 |" in text
