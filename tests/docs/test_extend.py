"""The code and the configurations of docs/extend.md do what the page says."""

from __future__ import annotations

import re
import sys
from typing import Any

import numpy as np
import pytest
import torch
from hydra.errors import ConfigCompositionException
from hydra.utils import instantiate
from PIL import Image

import evaluate
from blockstab.search.rsamp import RSamp
from blockstab.testing.photographs import BLOCKS, photograph
from models import configured
from tests.block_scene import STACK, picture
from tests.docs.pages import DOCS, blocks, commands, composed
from tests.synthetic import write_folder
from tests.tolerance import EXACT
from tests.toy_potentials import toy_potentials

PAGE = DOCS / "extend.md"
FILE = re.compile(r"# (mine/\S+)\n")


@pytest.fixture
def mine(tmp_path, monkeypatch):
    """The files that the page tells to write, in the folder it calls `mine`, beside the scene that it reads."""
    write_folder(photograph(*BLOCKS).frame, tmp_path / "my_scene")
    for text in (*blocks(PAGE, "python"), *blocks(PAGE, "yaml")):
        if named := FILE.match(text):
            target = tmp_path / named[1]
            target.parent.mkdir(parents=True, exist_ok=True)
            target.write_text(text)
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(str(tmp_path))
    yield tmp_path / "mine"
    for name in [name for name in sys.modules if name.split(".")[0] == "mine"]:
        del sys.modules[name]


def test_the_code_of_the_page_runs(mine):
    names: dict[str, Any] = {"__name__": "extend"}
    code = "\n".join(blocks(PAGE, "python"))
    exec(compile(code, str(PAGE), "exec", dont_inherit=True), names)
    trace = names["parsed"].trace
    assert list(trace) == sorted(trace, reverse=True)
    assert names["parsed"].energy == trace[-1]
    badness = names["unary"].badness(names["rows"].features)
    assert badness.shape == names["rows"].target.shape
    stored = np.asarray(Image.open("my_scene/ucm.png"), dtype=float) / 65535
    assert np.abs(stored - names["ucm"].numpy()).max() <= 0.5 / 65535 + EXACT


def test_the_proposal_of_the_page_finds_the_blocks(mine):
    proposal = instantiate(composed("train", ["proposals=islands"], mine).proposals)
    scene = picture(STACK)
    proposed = proposal(scene.observation)
    stands_out = scene.cloud.points[..., 1] > scene.ground.height + 0.03
    assert set(proposed.label[stands_out].tolist()) == {2}
    assert set(proposed.is_background) <= set(proposed.label.unique().tolist()) - {0}


def test_the_head_of_the_page_is_taken_by_training(mine):
    head = instantiate(composed("train", ["potential=quadratic"], mine).potential)
    assert head(5)(torch.zeros(3, 5)).shape == (3,)
    assert head(5).name == "quadratic"


def test_the_experiment_of_the_page_makes_its_parsers(mine, monkeypatch):
    monkeypatch.setattr(configured, "parsing_potentials", lambda *_: toy_potentials())
    changed = ["experiment=climbing", "experiment.methods.climb.search.moves=20"]
    methods = evaluate.methods_of(composed("evaluate", changed, mine))
    assert {name: type(method.parser.search).__name__ for name, method in methods.items()} == {
        "Climb": "Climb",
        "R-Samp": "RSamp",
    }
    assert all(method.scores == ("overlap",) for method in methods.values())
    assert methods["Climb"].parser.search.moves == 20


def test_a_misspelt_key_stops_the_run(mine):
    with pytest.raises(ConfigCompositionException, match="movs"):
        composed("evaluate", ["experiment=climbing", "experiment.methods.climb.search.movs=20"], mine)


@pytest.mark.parametrize("program", ["train", "evaluate"])
def test_every_command_of_the_page_is_accepted(mine, program):
    found = commands(PAGE, f"python {program}.py")
    assert found
    for option, folder, *overrides in found:
        assert (option, folder) == ("--config-dir", "mine")
        composed(program, overrides, mine)


@pytest.mark.parametrize("kind", ["Swallow", "Climb", "Careful", "Coarse", "Colourful"])
def test_the_parts_of_the_page_keep_the_contracts_of_the_page(mine, kind):
    names: dict[str, Any] = {"__name__": "test_mine"}
    exec(compile((mine / "test_mine.py").read_text(), "test_mine.py", "exec", dont_inherit=True), names)
    tests = names[f"Test{kind}"]()
    for name in dir(tests):
        if name.startswith("test_"):
            getattr(tests, name)()


def test_the_data_set_of_the_page_is_read(mine):
    made = instantiate(composed("evaluate", ["data=dimmed", f"data.root={mine.parent}"], mine).data)
    (scene,) = made.scenes()
    assert made.read(scene)[0].color.max() < 128


def test_the_judge_of_the_page_is_asked_by_the_rules(mine):
    rules = instantiate(composed("parse", ["judge=careful", "judge.least_margin_m=0.03"], mine).rules)
    assert rules.judge.least_margin_m == 0.03


def test_the_move_of_the_page_is_one_of_a_search(mine):
    search = instantiate(composed("parse", ["search=swallowing"], mine).search)
    assert search.moves[-1].most_px == 300
    assert search.rounds == RSamp().rounds


def test_the_columns_of_the_page_are_computed_for_training_and_for_parses(mine):
    for program in ("train", "parse", "evaluate"):
        (part,) = configured.own_columns(composed(program, ["columns=colourful"], mine))
        assert part.columns == ("colourful",)


def test_the_sensor_of_the_page_sees_simulated_scenes(mine, tmp_path):
    words = ["data=coarse", "data.count=1", f"data.cache={tmp_path}/cache", "+data.jobs=1"]
    made = instantiate(composed("train", words, mine).data)
    frame, _ = made.read(made.scenes()[0])
    assert frame.depth.shape == (240, 320)
    assert bool(((frame.depth / 0.005 - (frame.depth / 0.005).round()).abs() < 1e-6).all())
