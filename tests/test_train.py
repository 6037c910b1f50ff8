"""Training, from scene folders to potentials that a parse can use."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
import torch
from hydra.errors import HydraException

import train
from blockstab.features.columns import feature_set
from blockstab.parsing.parser import Parser
from blockstab.proposals.watershed import Watershed
from blockstab.search.rsamp import RSamp
from blockstab.testing.photographs import BLOCKS, photograph
from evaluate import methods_of
from models.potentials.checkpoint import CheckpointError
from models.potentials.heads import TreesHead
from models.potentials.parsing import parsing_potentials
from models.potentials.rows import KINDS
from tests.docs.pages import ROOT, composed
from tests.own_columns import Height
from tests.synthetic import write_folder
from tests.tolerance import EXACT

QUICK = [
    "examples.walks=1",
    "examples.steps=2",
    "examples.most_states=6",
    "search.rounds=1",
    "fit.folds=3",
    "rounds=1",
    "jobs=1",
]
TREES = ["potential=trees", "potential.trees=10", "potential.leaves=4"]


@pytest.fixture(autouse=True, scope="module")
def threads() -> Iterator[None]:
    """Training takes one thread; the tests after it get theirs back."""
    before = torch.get_num_threads()
    yield
    torch.set_num_threads(before)


@pytest.fixture(scope="module")
def place(tmp_path_factory) -> Path:
    """Five scenes, a cache, and what was trained on them."""
    root = tmp_path_factory.mktemp("training")
    for k in range(5):
        turned = photograph(*BLOCKS[: 2 + k % 3], turn_deg=10.0 * k, seed=k)
        write_folder(turned.frame, root / "scenes" / f"scene{k}")
    trained(root, "mine")
    return root


def training(root: Path, name: str, *overrides: str) -> list[str]:
    folders = [f"data.root={root}/scenes", f"cache={root}/cache", f"splits={root}/splits"]
    return ["data=folder", *folders, f"output={root}/{name}", *TREES, *QUICK, *overrides]


def trained(root: Path, name: str, *overrides: str) -> Path:
    train.run(composed("train", training(root, name, *overrides)))
    return root / name


def test_what_was_trained_is_potentials_of_every_kind_with_their_making(place):
    loaded = parsing_potentials(place / "mine")
    for kind in KINDS:
        potential = getattr(loaded, kind).potential
        assert type(potential.head) is TreesHead
        assert potential.columns == feature_set("all").of(kind)


def test_a_parse_can_use_it(place):
    parse = Parser(Watershed(), RSamp(rounds=2), parsing_potentials(place / "mine"))
    parsed = parse(photograph(*BLOCKS).frame)
    assert parsed.potentials_name == "mine"
    assert list(parsed.trace) == sorted(parsed.trace, reverse=True)
    assert bool(((parsed.badness >= 0) & (parsed.badness <= 1)).all())


def test_a_second_time_the_examples_are_there_and_the_same_comes_out(place):
    before = {file.name: file.stat().st_mtime_ns for file in (place / "cache").iterdir()}
    again = trained(place, "again")
    after = {file.name: file.stat().st_mtime_ns for file in (place / "cache").iterdir()}
    assert after == before
    one, other = (stem.with_suffix(".safetensors").read_bytes() for stem in (place / "mine", again))
    assert one == other


def test_every_round_learns_from_what_a_search_visits_too(place):
    parsing = parsing_potentials(trained(place, "first", "rounds=0"))
    records = [json.loads((place / f"{name}.json").read_text()) for name in ("first", "mine")]
    first, mine = (record["provenance"]["potentials"]["unary"]["rows"] for record in records)
    assert mine > first
    assert parsing.weight >= 0


def test_ablations_are_trained_on_the_same_examples_with_other_columns(place):
    before = {file.name for file in (place / "cache").iterdir()}
    trained(place, "both", "ablations=[without_stability]")
    assert {file.name for file in (place / "cache").iterdir()} == before
    assert (place / "both.safetensors").read_bytes() == (place / "mine.safetensors").read_bytes()
    less = parsing_potentials(place / "both_without_stability.json")
    assert less.unary.potential.columns == feature_set("without_stability").unary
    told = [
        json.loads((place / f"both{end}.json").read_text())["provenance"]
        for end in ("", "_without_stability")
    ]
    assert [facts.get("ablation") for facts in told] == [None, "without_stability"]


def test_a_round_searches_so_many_scenes(place):
    trained(place, "few", "examples.searched=2", f"cache={place}/few_cache")
    assert len(list((place / "few_cache").iterdir())) == 5 + 2


def test_features_target_and_structured_learning_are_choices(place):
    stem = trained(place, "paper", "features=paper", "fit.target=bit", "fit.structured=false", "rounds=0")
    loaded = parsing_potentials(stem)
    assert loaded.unary.potential.columns == feature_set("paper").unary


def test_columns_of_ones_own_are_learned_from_and_asked_for_by_a_parse(place):
    own = "+columns.mine={_target_: tests.own_columns.Height}"
    stem = trained(place, "own", own, "features=paper", "rounds=1", f"cache={place}/own_cache")
    with pytest.raises(
        CheckpointError, match="'height', which this version does not compute; say `columns=`"
    ):
        parsing_potentials(stem)
    loaded = parsing_potentials(stem, columns=[Height()])
    assert loaded.unary.potential.columns == (*feature_set("paper").unary, "height")
    assert loaded.alone.potential.columns == feature_set("paper").of("alone")
    (parser,) = (
        method.parser
        for method in methods_of(
            composed("evaluate", [own, "experiment=table4", "methods=[rsamp]", f"potentials={stem}.json"])
        ).values()
    )
    parsed = parser(photograph(*BLOCKS).frame)
    assert bool(((parsed.badness >= 0) & (parsed.badness <= 1)).all())


@pytest.mark.parametrize("override", ["task=stages", "task=boundary"])
def test_a_setting_that_a_task_does_not_know_is_refused(override):
    with pytest.raises(HydraException, match="potential"):
        composed("train", [override, "potential=trees"])
    with pytest.raises(HydraException, match="rounds"):
        composed("train", [override, "rounds=1"])


def test_a_run_tells_how_well_it_ranks_what_it_has_not_seen(place):
    loss = train.run(composed("train", training(place, "told", "rounds=0")))
    record = json.loads((place / "told.json").read_text())
    auc = record["provenance"]["potentials"]["unary"]["held_out_auc"]
    assert loss == pytest.approx(1.0 - auc, abs=EXACT)


def test_two_jobs_of_a_sweep_keep_what_each_has_trained(place, tmp_path):
    words = [w for w in training(place, "sweep", "rounds=0") if not w.startswith("output=")]
    swept = subprocess.run(
        [sys.executable, str(ROOT / "train.py"), "-m", "seed=0,1", *words],
        cwd=tmp_path,
        env={**os.environ, "OMP_NUM_THREADS": "1"},
        capture_output=True,
        text=True,
    )
    assert swept.returncode == 0, swept.stderr
    one, other = sorted(tmp_path.glob("out/train/*/*/potentials.safetensors"))
    assert (one.parent.name, other.parent.name) == ("0", "1")
    assert one.read_bytes() != other.read_bytes()
