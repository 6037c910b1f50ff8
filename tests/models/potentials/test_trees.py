"""LightGBM's text: read as LightGBM reads it, and refused in one line where it would end the process."""

from __future__ import annotations

import random
import subprocess
import sys
from functools import cache
from pathlib import Path

import numpy as np
import pytest
import torch
from lightgbm import Booster

from models.potentials.checkpoint import load_potentials, save_potentials
from models.potentials.heads import Potential, TreesHead
from models.potentials.record import CheckpointError
from models.potentials.rows import KINDS
from models.potentials.trees import booster, checked_trees
from models.stages.stages import load_stages

FEATURES = 3


@cache
def head() -> TreesHead:
    """Six trees of five leaves, over three features."""
    rows = torch.randn(400, FEATURES, generator=torch.Generator().manual_seed(0), dtype=torch.float64)
    target = (rows[:, 0] * rows[:, 1] > 0).double()
    return TreesHead(FEATURES, trees=6, leaves=5).grown(rows, target, torch.ones(400).double(), 1.0, 0)


@cache
def text() -> str:
    return bytes(head().text.numpy()).decode()


def test_the_trees_judge_as_lightgbm_does_of_the_whole_text():
    rows = np.random.default_rng(0).normal(size=(200, FEATURES))
    whole = Booster(model_str=text()).predict(rows, num_threads=1)
    assert np.array_equal(booster(text(), FEATURES).predict(rows, num_threads=1), whole)
    assert np.array_equal(head()(torch.from_numpy(rows)).numpy(), whole)


def test_so_do_the_stages_that_come_with_the_package():
    rows = np.random.default_rng(0).normal(size=(200, 51))
    for stage in load_stages("silberman").stages:
        whole = Booster(model_str=stage.trees).predict(rows, num_threads=1)
        assert np.array_equal(stage(torch.from_numpy(rows)).numpy(), whole)


def test_a_tree_that_found_nothing_to_split_is_read():
    flat = TreesHead(FEATURES, trees=3, leaves=4).grown(
        torch.zeros(50, FEATURES).double(), torch.full((50,), 0.7).double(), torch.ones(50).double(), 1.0, 0
    )
    assert flat(torch.randn(4, FEATURES)).tolist() == pytest.approx([0.7] * 4)


def test_training_and_its_files_are_left_out_of_what_lightgbm_is_given():
    given = checked_trees(text(), FEATURES)
    assert "parameters" in text()
    assert "parameters" not in given
    assert given.count("Tree=") == 6
    assert checked_trees(given, FEATURES) == given


SPOILT = {
    "nothing": lambda t: "",
    "other text": lambda t: "hello",
    "no ascii": lambda t: t.replace("Tree=1", "Tree=é"),
    "cut short": lambda t: t[: t.index("Tree=4") + 60],
    "without an end": lambda t: t.replace("end of trees", "more trees"),
    "a tree less": lambda t: t.replace("tree_sizes=", "tree_sizes=9 "),
    "of other features": lambda t: t.replace("max_feature_idx=2", "max_feature_idx=9"),
    "a feature too far": lambda t: t.replace("split_feature=", "split_feature=3", 1),
    "a child beyond the leaves": lambda t: t.replace("left_child=1", "left_child=9", 1),
    "a child before its parent": lambda t: t.replace("left_child=1", "left_child=0", 1),
    "a leaf that is no number": lambda t: _with_first(t, "leaf_value", "nan"),
    "a threshold that is none": lambda t: _with_first(t, "threshold", "0x12"),
    "categories": lambda t: _with_first(t, "decision_type", "1"),
    "linear leaves": lambda t: t.replace("is_linear=0", "is_linear=1", 1),
    "too many leaves": lambda t: t.replace("num_leaves=5", "num_leaves=4", 1),
    "another objective": lambda t: t.replace("objective=cross_entropy", "objective=multiclass"),
}


def _with_first(whole: str, name: str, value: str) -> str:
    """The text with the first value of that name replaced by one as long as it, so that sizes stay."""
    start = whole.index(f"\n{name}=") + len(name) + 2
    length = whole[start:].replace("\n", " ").index(" ")
    return whole[:start] + value.ljust(length, "0")[: max(length, len(value))] + whole[start + length :]


@pytest.mark.parametrize("how", SPOILT)
def test_a_damaged_text_is_one_clear_error(how):
    spoilt = SPOILT[how](text())
    assert spoilt != text()
    with pytest.raises(ValueError, match="the trees cannot be read: ") as caught:
        booster(spoilt, FEATURES)
    assert "\n" not in str(caught.value)
    assert len(str(caught.value)) < 250


@pytest.mark.parametrize("how", ["cut short", "a child before its parent"])
def test_a_checkpoint_with_damaged_trees_is_refused_when_it_is_read(how, tmp_path):
    letters = torch.frombuffer(bytearray(SPOILT[how](text()).encode()), dtype=torch.uint8)
    spoilt = TreesHead(FEATURES, 6, 5, len(letters))
    spoilt.text.copy_(letters)
    kinds = {
        kind: Potential(("a", "b", "c"), spoilt if kind == "alone" else head(), torch.zeros(3), torch.ones(3))
        for kind in KINDS
    }
    save_potentials(tmp_path / "mine", kinds, 0.0, {})
    with pytest.raises(
        CheckpointError, match=r"mine\.safetensors holds no alone potential: the trees"
    ) as caught:
        load_potentials(tmp_path / "mine")
    assert "\n" not in str(caught.value)


def damaged(seed: int) -> str:
    """The text with letters changed, lost or doubled at random."""
    draw, letters = random.Random(seed), list(text())
    place = draw.randrange(len(letters) if draw.random() < 0.3 else text().index("end of trees"))
    match draw.randrange(3):
        case 0:
            letters[place] = draw.choice("0123456789-.= \nae")
        case 1:
            del letters[place : place + draw.randrange(1, 30)]
        case _:
            start = draw.randrange(len(letters))
            letters[place:place] = letters[start : start + draw.randrange(1, 40)]
    return "".join(letters)


def judge_damaged(count: int) -> int:
    """How many of so many damaged texts are refused; the others judge a row."""
    refused = 0
    for seed in range(count):
        try:
            booster(damaged(seed), FEATURES).predict(np.zeros((1, FEATURES)), num_threads=1)
        except ValueError:
            refused += 1
    return refused


def test_no_damage_ends_the_process():
    program = "from tests.models.potentials.test_trees import judge_damaged; print(judge_damaged(600))"
    root = Path(__file__).parents[3]
    ended = subprocess.run(
        [sys.executable, "-c", program], cwd=root, capture_output=True, text=True, check=False
    )
    assert ended.returncode == 0
    assert 200 < int(ended.stdout.split()[-1]) < 600
