"""Sets of simulated scenes are the same bytes, in however many goes and by however many jobs."""

from __future__ import annotations

import json
import resource
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
import torch

from blockstab.datasets.folder import read_truth, scene_folders
from blockstab.rgbd.frame import read_scene
from blockstab.simulation.simulated import Recipe, simulate_scene
from blockstab.simulation.writing import write_simulated

pytest.importorskip("mujoco", reason="the extra `sim` is not installed")

RECIPE = Recipe("blocks", seed=3)
CLI = (sys.executable, "-c", "from blockstab.cli import main; main()")
FILES = ["boundary.png", "color.png", "depth.png", "label.png", "meta.json"]


def same_bytes(first: Path, second: Path, names: list[str]) -> bool:
    return all((first / name).read_bytes() == (second / name).read_bytes() for name in names)


@pytest.fixture(scope="module")
def written(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Two scenes, made by one job."""
    root = tmp_path_factory.mktemp("one")
    write_simulated(root, RECIPE, 2)
    return root


def test_scenes_and_bytes_do_not_depend_on_the_number_of_jobs(tmp_path: Path, written: Path) -> None:
    two = write_simulated(tmp_path, RECIPE, 2, jobs=2)
    assert [f.name for f in two] == ["blocks_0000", "blocks_0001"]
    for folder in two:
        assert sorted(f.name for f in folder.iterdir()) == FILES
        assert same_bytes(folder, written / folder.name, FILES)
    assert same_bytes(tmp_path, written, ["contact_sheet.png", "census.json"])
    assert not same_bytes(two[0], two[1], ["depth.png"])


def test_a_written_scene_is_the_simulated_one(written: Path) -> None:
    folder = written / "blocks_0000"
    frame, truth = simulate_scene(RECIPE, 0)
    found, told = read_scene(folder), read_truth(folder)
    assert found.name == frame.name
    assert torch.equal(found.color, frame.color)
    assert torch.equal(found.depth, frame.depth)
    assert found.label is not None
    assert frame.label is not None
    assert torch.equal(found.label, frame.label)
    assert told.boundary is not None
    assert truth.boundary is not None
    assert torch.equal(told.boundary, truth.boundary)
    assert told.support_annotated
    assert [(o.supported_by, o.falls_if_removed, o.support_types) for o in told.objects] == [
        (o.supported_by, o.falls_if_removed, o.support_types) for o in truth.objects
    ]


def test_a_second_run_makes_only_what_is_missing(tmp_path: Path, written: Path) -> None:
    first = tmp_path / "blocks_0000"
    shutil.copytree(written / "blocks_0000", first)
    kept = first.stat().st_ino
    assert write_simulated(tmp_path, RECIPE, 2) == scene_folders(tmp_path)
    assert first.stat().st_ino == kept
    assert same_bytes(tmp_path / "blocks_0001", written / "blocks_0001", FILES)


def test_another_seed_replaces_the_scenes(tmp_path: Path, written: Path) -> None:
    shutil.copytree(written / "blocks_0000", tmp_path / "blocks_0000")
    (folder,) = write_simulated(tmp_path, Recipe("blocks", seed=4), 1)
    assert not same_bytes(folder, written / "blocks_0000", ["depth.png"])
    assert sorted(f.name for f in tmp_path.iterdir()) == ["blocks_0000", "census.json", "contact_sheet.png"]


def test_a_folder_that_is_no_simulated_scene_is_not_overwritten(tmp_path: Path) -> None:
    (tmp_path / "blocks_0001").mkdir()
    (tmp_path / "blocks_0001" / "thesis.txt").write_text("mine")
    with pytest.raises(ValueError, match="blocks_0001 exists and is no simulated scene"):
        write_simulated(tmp_path, RECIPE, 2)
    assert not (tmp_path / "blocks_0000").exists()
    assert (tmp_path / "blocks_0001" / "thesis.txt").read_text() == "mine"


@pytest.mark.parametrize(("count", "jobs"), [(0, 1), (1, 0)])
def test_numbers_out_of_range_are_named(tmp_path: Path, count: int, jobs: int) -> None:
    with pytest.raises(ValueError, match=f"count is {count} and jobs {jobs}"):
        write_simulated(tmp_path, RECIPE, count, jobs)


def test_a_run_without_the_engine_says_so_before_it_writes(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "mujoco", None)
    with pytest.raises(ModuleNotFoundError, match=r"pip install 'blockstab\[sim\]'"):
        write_simulated(tmp_path / "out", RECIPE, 1)
    assert not (tmp_path / "out").exists()


def no_room() -> None:
    """What a full disk does to a process: its files stop growing."""
    resource.setrlimit(resource.RLIMIT_FSIZE, (20_000, 20_000))


def test_a_disk_that_fills_up_gives_one_line_and_leaves_no_half_scene(tmp_path: Path) -> None:
    command = [*CLI, "simulate", "--count", "1", "--out", str(tmp_path)]
    run = subprocess.run(command, capture_output=True, text=True, preexec_fn=no_room)
    assert run.returncode == 1
    last = run.stderr.strip().splitlines()[-1]
    assert "File too large" in last
    assert "the same command goes on" in last
    assert "Traceback" not in run.stderr
    assert scene_folders(tmp_path) == []
    assert list(tmp_path.iterdir()) == []


def test_an_output_folder_that_cannot_be_written_is_named_before_anything_is_simulated(
    tmp_path: Path,
) -> None:
    (tmp_path / "file").write_text("mine")
    with pytest.raises(OSError) as caught:
        write_simulated(tmp_path / "file" / "scenes", RECIPE, 1)
    assert str(tmp_path / "file") in str(caught.value.filename)


def test_the_census_counts_what_the_scenes_say(written: Path) -> None:
    census = json.loads((written / "census.json").read_text())
    truths = [read_truth(folder) for folder in scene_folders(written)]
    objects = [o for truth in truths for o in truth.objects]
    assert census["objects"] == len(objects)
    assert census["scenes"] == 2
    stacked = sum(any(i != 1 for i in o.supported_by or ()) for o in objects)
    assert census["on_objects"] == pytest.approx(stacked / len(objects), abs=1e-4)
    assert sum(census["supports"].values()) == sum(len(o.supported_by or ()) for o in objects)
