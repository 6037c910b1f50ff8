"""What is installed is whole: a wheel works in a folder that knows nothing of the checkout."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

from blockstab.testing.photographs import BLOCKS, photograph
from tests.docs.pages import ROOT
from tests.synthetic import write_folder

START = {
    "blockstab": "from blockstab.cli import main; main()",
    "blockstab-train": "from models.programs.train import main; main()",
    "blockstab-evaluate": "from models.programs.evaluate import main; main()",
}


@pytest.fixture(scope="module")
def installed(tmp_path_factory) -> Path:
    """A folder with what the wheel holds."""
    place = tmp_path_factory.mktemp("wheel")
    subprocess.run(
        [sys.executable, "-m", "hatchling", "build", "-t", "wheel", "-d", str(place)],
        cwd=ROOT,
        check=True,
        capture_output=True,
    )
    (wheel,) = place.glob("*.whl")
    zipfile.ZipFile(wheel).extractall(place / "site")
    return place / "site"


@pytest.fixture
def empty(tmp_path) -> Path:
    """An empty folder but for three scenes."""
    for k in range(3):
        write_folder(photograph(*BLOCKS, seed=k, turn_deg=10.0 * k).frame, tmp_path / "scenes" / f"scene{k}")
    return tmp_path


def run(installed: Path, folder: Path, program: str, *words: str) -> str:
    found = subprocess.run(
        [sys.executable, "-c", START[program], *words],
        cwd=folder,
        env={**os.environ, "PYTHONPATH": str(installed), "OMP_NUM_THREADS": "1"},
        capture_output=True,
        text=True,
    )
    assert found.returncode == 0, found.stderr
    return found.stdout


def test_it_has_the_configurations_and_the_potentials_and_says_which_programs_there_are(installed):
    assert (installed / "blockstab" / "configs" / "method" / "rsamp.yaml").is_file()
    assert (installed / "models" / "pretrained" / "trees.json").is_file()
    (points,) = installed.glob("*.dist-info/entry_points.txt")
    for program in START:
        assert f"{program} = " in points.read_text()


def test_it_is_the_wheel_that_runs(installed, empty):
    where = subprocess.run(
        [sys.executable, "-c", "import models.configured as c; print(c.CONFIGS)"],
        cwd=empty,
        env={**os.environ, "PYTHONPATH": str(installed)},
        capture_output=True,
        text=True,
    )
    assert Path(where.stdout.strip()) == installed / "blockstab" / "configs"


def test_it_parses_trains_and_evaluates_outside_the_checkout(installed, empty):
    run(installed, empty, "blockstab", "parse", "scenes/scene0", "search=greedy", "--out", "parsed")
    assert (empty / "parsed" / "scene0" / "report.html").is_file()
    data = ("data=folder", "data.root=scenes", "jobs=1")
    few = ("fit.folds=2", "examples.walks=1", "examples.steps=1", "fit.most_rows=200")
    run(installed, empty, "blockstab-train", *data, *few, "output=mine")
    assert (empty / "mine.safetensors").is_file()
    some = ("experiment=segments", "methods=[start]", "potentials=mine.json", "out=compared")
    run(installed, empty, "blockstab-evaluate", *data, *some)
    (row,) = json.loads((empty / "compared" / "results.json").read_text())["rows"]
    assert (row["method"], row["potential"]) == ("Start", "mine")
