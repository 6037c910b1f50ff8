"""The command line, as a user types it."""

from __future__ import annotations

import json
import shutil
from dataclasses import replace
from pathlib import Path

import jsonschema
import numpy as np
import pytest
import torch
from click.testing import Result
from PIL import Image
from typer.testing import CliRunner

from blockstab.cli import app
from blockstab.output.export import scene_schema
from blockstab.testing.photographs import BLOCKS, photograph
from models.potentials.checkpoint import save_potentials
from models.potentials.heads import Potential
from tests.synthetic import write_folder
from tests.toy_potentials import kinds_of, linear, toy_potentials

HALVES = """\
import torch
from blockstab.proposals import Proposed

class Halves:
    def __call__(self, observation):
        column = torch.arange(observation.fine.shape[1]).expand_as(observation.fine)
        return Proposed(1 + (column > column.max() // 2).long(), {})
"""


@pytest.fixture(scope="module")
def scene(tmp_path_factory) -> Path:
    """A good scene folder."""
    return write_folder(photograph(*BLOCKS).frame, tmp_path_factory.mktemp("scenes") / "blocks")


@pytest.fixture(scope="module")
def potentials(tmp_path_factory) -> Path:
    """A potentials file of one's own."""
    return saved(tmp_path_factory.mktemp("potentials") / "mine")


@pytest.fixture(autouse=True)
def threads():
    """Parsing takes one thread; the tests after it get theirs back."""
    before = torch.get_num_threads()
    yield
    torch.set_num_threads(before)


def saved(stem: Path, **changes: Potential) -> Path:
    save_potentials(stem, kinds_of(toy_potentials(), **changes), 0.1, {"data": "toy"})
    return stem.with_suffix(".json")


def run(*arguments: str | Path) -> Result:
    return CliRunner().invoke(app, [str(argument) for argument in arguments])


def quick(*arguments: str | Path) -> Result:
    """Parse the labels of the scene itself, without a search."""
    return run("parse", "--proposals", "labels", "--search", "none", *arguments)


def refusal(result: Result) -> str:
    """What a wrong command is told, without the frame around it."""
    assert result.exit_code == 2
    return " ".join(result.stderr.replace("│", " ").split())


def assert_stopped(result: Result, *words: str) -> None:
    """One line that says what is wrong, and no traceback."""
    assert result.exit_code == 1
    assert isinstance(result.exception, SystemExit)
    assert result.stderr.count("\n") == 1
    for word in words:
        assert word in result.stderr


def record(folder: Path) -> dict:
    return json.loads((folder / "scene.json").read_text())


def test_a_scene_folder_gives_labels_a_report_and_a_record(scene, potentials, tmp_path):
    result = quick(scene, "--potentials", potentials, "--out", tmp_path / "out")
    assert result.exit_code == 0
    assert "1 of 1 scenes parsed" in result.stdout
    found = {file.name for file in (tmp_path / "out" / "blocks").iterdir()}
    assert {"labels.png", "report.html", "scene.json"} <= found
    jsonschema.validate(record(tmp_path / "out" / "blocks"), scene_schema())
    given, kept = (
        np.asarray(Image.open(f)) for f in (scene / "label.png", tmp_path / "out/blocks/labels.png")
    )
    assert np.array_equal(given, kept)


def test_the_potentials_used_are_named(scene, potentials, tmp_path):
    quick(scene, "--potentials", potentials, "--out", tmp_path)
    digest = json.loads(potentials.read_text())["sha256"]
    assert record(tmp_path / "blocks")["potentials"] == {"name": "mine", "sha256": digest}


def test_a_broken_scene_is_named_and_the_good_one_is_written(scene, potentials, tmp_path):
    broken = write_folder(photograph(*BLOCKS).frame, tmp_path / "broken")
    (broken / "meta.json").write_text("{")
    result = quick(broken, scene, "--potentials", potentials, "--out", tmp_path / "out")
    assert_names_the_file(result, broken / "meta.json")
    assert "1 of 2 scenes parsed" in result.stdout
    assert [folder.name for folder in (tmp_path / "out").iterdir()] == ["blocks"]


def assert_names_the_file(result: Result, file: Path) -> None:
    assert result.exit_code == 1
    assert str(file) in result.stderr
    assert "Traceback" not in result.output


def test_a_folder_that_is_not_there_is_named(potentials, tmp_path):
    result = quick(tmp_path / "nowhere", "--potentials", potentials, "--out", tmp_path / "out")
    assert_names_the_file(result, tmp_path / "nowhere" / "meta.json")


def test_loose_files_are_parsed_with_the_camera_given(scene, potentials, tmp_path):
    loose = ["--color", scene / "color.png", "--depth", scene / "depth.png"]
    camera = ["--fx", "260", "--fy", "260", "--cx", "95.5", "--cy", "71.5"]
    common = ["parse", *loose, "--search", "none", "--potentials", potentials, "--out", tmp_path]
    assert run(*common, *camera).exit_code == 0
    first = record(tmp_path / "color")
    assert sum(not segment["background"] for segment in first["segments"]) >= 2
    # Another camera is another image: what was made with the first does not stand.
    assert run(*common, *camera[:-1], "60").exit_code == 0
    assert record(tmp_path / "color")["segments"] != first["segments"]


def test_loose_files_have_the_noise_of_the_sensor_that_is_named(scene, potentials, tmp_path):
    loose = ["--color", scene / "color.png", "--depth", scene / "depth.png"]
    camera = ["--fx", "260", "--fy", "260", "--cx", "95.5", "--cy", "71.5"]
    common = ["parse", *loose, *camera, "--search", "none", "--potentials", potentials]
    boxes = {}
    for sensor in ("kinect", "realsense"):
        assert run(*common, "--sensor", sensor, "--out", tmp_path / sensor).exit_code == 0
        boxes[sensor] = [segment["box"] for segment in record(tmp_path / sensor / "color")["segments"]]
    assert boxes["kinect"] != boxes["realsense"]
    said = refusal(run(*common, "--sensor", "loud", "--out", tmp_path))
    assert all(word in said for word in ("--sensor", "kinect", "realsense", "ideal", "loud"))


@pytest.mark.parametrize("missing", ["--color", "--depth"])
def test_half_a_pair_of_loose_files_is_refused(scene, missing):
    given = {"--color": scene / "color.png", "--depth": scene / "depth.png"}
    del given[missing]
    result = run("parse", *(word for pair in given.items() for word in pair))
    assert "belong together" in refusal(result)


def test_loose_files_without_a_camera_are_refused(scene, potentials, tmp_path):
    loose = ["--color", scene / "color.png", "--depth", scene / "depth.png"]
    result = run("parse", *loose, "--potentials", potentials, "--out", tmp_path)
    assert result.exit_code == 1
    assert "fx must be a positive number" in result.stderr


def test_nothing_to_parse_is_said_and_what_to_give(tmp_path):
    said = refusal(run("parse", "--out", tmp_path))
    assert all(word in said for word in ("scene folders", "--color", "--fx"))


@pytest.mark.parametrize("name", ["unknown", "nowhere.json"])
def test_unknown_potentials_are_refused_in_one_line(scene, name, tmp_path):
    assert_stopped(quick(scene, "--potentials", name, "--out", tmp_path), name)


def test_potentials_of_other_features_are_refused_in_one_line(scene, tmp_path):
    other = linear(["volume", *(f"other_{k}" for k in range(11))], {}, 0.0)
    file = saved(tmp_path / "other", pairwise=other)
    assert_stopped(quick(scene, "--potentials", file, "--out", tmp_path), "'volume'", "train it anew")


def test_potentials_without_one_kind_are_refused_in_one_line(scene, tmp_path):
    file = saved(tmp_path / "less")
    record = json.loads(file.read_text())
    del record["potentials"]["alone"]
    file.write_text(json.dumps(record))
    assert_stopped(
        quick(scene, "--potentials", file, "--out", tmp_path), "less.json", "['alone'] are missing"
    )


def test_two_scenes_of_one_name_are_refused_in_one_line(scene, potentials, tmp_path):
    assert_stopped(quick(scene, scene, "--potentials", potentials, "--out", tmp_path), "2 are called blocks")


@pytest.mark.parametrize("option", ["--search", "--proposals", "--up"])
def test_a_misspelt_choice_is_refused_and_the_choices_are_told(scene, option):
    said = refusal(run("parse", scene, option, "rsmap"))
    assert "rsmap" in said
    assert {"--search": "rsamp", "--proposals": "watershed", "--up": "estimate"}[option] in said


@pytest.mark.parametrize("up", ["estimate", "meta"])
def test_up_comes_from_where_it_is_told(potentials, tmp_path, up):
    frame = photograph(*BLOCKS).frame
    odd = frame.up_camera + torch.tensor([0.05, 0.0, 0.0], dtype=torch.float64)
    folder = write_folder(replace(frame, up_camera=odd / odd.norm()), tmp_path / "odd")
    assert quick(folder, "--up", up, "--potentials", potentials, "--out", tmp_path / "out").exit_code == 0
    found = torch.tensor(record(tmp_path / "out" / "odd")["up_camera"], dtype=torch.float64)
    given = found @ (odd / odd.norm()) > 0.99999
    assert bool(given) == (up == "meta")


@pytest.mark.parametrize("search", ["none", "greedy", "rsamp"])
def test_every_search_can_be_chosen(scene, potentials, tmp_path, search):
    result = run("parse", scene, "--search", search, "--potentials", potentials, "--out", tmp_path)
    assert result.exit_code == 0
    rounds = len(record(tmp_path / "blocks")["energy_trace"])
    assert rounds == 1 if search == "none" else rounds >= 1


def test_felzenszwalb_can_be_chosen(scene, potentials, tmp_path):
    common = ["--search", "none", "--potentials", potentials, "--out", tmp_path]
    assert run("parse", scene, "--proposals", "felzenszwalb", *common).exit_code == 0


def masks_of(scene: Path, folder: Path, columns: int) -> str:
    """A label image of the left `columns` of a scene's labels, and the path that leads to it."""
    label = np.array(Image.open(scene / "label.png"))
    label[:, columns:] = 0
    folder.mkdir(exist_ok=True)
    Image.fromarray(label).save(folder / "blocks.png")
    return f"{folder}/{{scene}}.png"


def test_masks_of_another_segmenter_are_parsed_and_again_when_they_change(scene, potentials, tmp_path):
    common = ["--search", "none", "--potentials", potentials, "--out", tmp_path / "out"]
    seen = []
    for columns in (1000, 60):
        path = masks_of(scene, tmp_path / "masks", columns)
        assert run("parse", scene, "--proposals", "files", "--masks", path, *common).exit_code == 0
        seen.append({s["id"]: s["pixels"] for s in record(tmp_path / "out" / "blocks")["segments"]})
    whole, left = seen
    assert set(np.unique(np.array(Image.open(scene / "label.png")))) - {0} <= set(whole)
    assert sum(left.values()) < sum(whole.values())


def test_missing_masks_are_named_for_their_scene(scene, potentials, tmp_path):
    path = f"{tmp_path}/{{scene}}_masks.json"
    common = ["--potentials", potentials, "--out", tmp_path / "out"]
    result = run("parse", scene, "--proposals", "files", "--masks", path, *common)
    assert_names_the_file(result, tmp_path / "blocks_masks.json")


@pytest.mark.parametrize("given", [["--proposals", "files"], ["--masks", "a.json"]])
def test_files_and_their_path_belong_together(scene, given):
    assert "belong together" in refusal(run("parse", scene, *given))


def test_masks_of_several_scenes_need_their_names(scene, tmp_path):
    result = run("parse", scene, tmp_path, "--proposals", "files", "--masks", "a.json")
    assert "needs {scene} in its path" in refusal(result)


def test_masks_of_an_unknown_kind_are_refused_in_one_line(scene):
    result = run("parse", scene, "--proposals", "files", "--masks", "a.pkl")
    assert_stopped(result, "a.pkl", ".npz")


def test_the_seed_is_kept(scene, potentials, tmp_path):
    quick(scene, "--seed", "12", "--potentials", potentials, "--out", tmp_path)
    assert record(tmp_path / "blocks")["seed"] == 12


@pytest.mark.parametrize("command", [[], ["parse"], ["simulate"]])
def test_help_is_there(command):
    result = run(*command, "--help")
    assert result.exit_code == 0
    assert "Usage" in result.stdout


def test_an_unknown_preset_is_refused_in_one_line(tmp_path):
    assert_stopped(run("simulate", "--preset", "moon", "--out", tmp_path / "out"), "moon")


def test_any_key_of_the_configuration_can_be_set_among_the_scenes(scene, potentials, tmp_path):
    result = run(
        "parse",
        scene,
        "search=greedy",
        "rules=minimum_surface",
        f"potentials={potentials}",
        "--out",
        tmp_path,
    )
    assert result.exit_code == 0
    assert record(tmp_path / scene.name)["potentials"]["name"] == "mine"


def test_a_key_that_is_not_there_is_refused(scene):
    assert "search.rouns" in refusal(run("parse", scene, "search.rouns=3"))
    assert "search=[" in refusal(run("parse", scene, "search=["))


def test_a_folder_with_an_equals_sign_in_its_name_is_a_scene_all_the_same(scene, potentials, tmp_path):
    folder = tmp_path / "a=b"
    shutil.copytree(scene, folder)
    assert quick(folder, "--potentials", potentials, "--out", tmp_path / "out").exit_code == 0
    assert (tmp_path / "out" / "a=b" / "scene.json").exists()


def test_a_proposal_of_ones_own_is_taken_by_name(scene, potentials, tmp_path, monkeypatch):
    (tmp_path / "own" / "proposals").mkdir(parents=True)
    (tmp_path / "own" / "proposals" / "halves.yaml").write_text("_target_: own_halves.Halves\n")
    (tmp_path / "own_halves.py").write_text(HALVES)
    monkeypatch.chdir(tmp_path)
    mine = ["--config-dir", "own", "--proposals", "halves", "--search", "none"]
    result = run("parse", scene, *mine, "--potentials", potentials, "--out", "out")
    assert result.exit_code == 0, result.stderr
    assert len(record(tmp_path / "out" / scene.name)["segments"]) == 2
