"""Learned stages of merging: what a file keeps, and what a damaged one says."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
import torch

from blockstab.features.appearance.pair_columns import APPEARANCE_COLUMNS
from models.potentials.record import CheckpointError
from models.stages.stages import BoostedStage, StagedMerging, load_stages, save_stages, silberman
from models.stages.training import StagePlan, boosted
from tests.block_scene import STACK, picture

STRENGTH = APPEARANCE_COLUMNS.index("strength")


def learned(threshold: float = 0.6) -> BoostedStage:
    """A stage that has seen strong edgelets part objects and weak ones lie within."""
    rows = torch.rand(400, len(APPEARANCE_COLUMNS), generator=torch.Generator().manual_seed(3)).double()
    trees, _ = boosted(rows, rows[:, STRENGTH] < 0.5, StagePlan(threshold, trees=10, leaves=4), seed=0)
    return BoostedStage(threshold, trees)


@pytest.fixture(scope="module")
def merging() -> StagedMerging:
    return StagedMerging("fixed", (learned(0.6), learned(0.55)), {"images": 3})


@pytest.fixture
def file(merging: StagedMerging, tmp_path: Path) -> Path:
    save_stages(tmp_path / "mine.json", merging)
    return tmp_path / "mine.json"


def test_a_stage_is_surer_of_what_looked_alike_in_training(merging: StagedMerging) -> None:
    weak, strong = torch.full((2, len(APPEARANCE_COLUMNS)), 0.5).double()
    weak[STRENGTH], strong[STRENGTH] = 0.1, 0.9
    within, apart = merging.stages[0](torch.stack([weak, strong])).tolist()
    assert within > 0.8
    assert apart < 0.2


def test_confidence_is_the_share_of_edgelets_within_an_object_among_those_that_look_alike() -> None:
    rows = torch.zeros(4000, len(APPEARANCE_COLUMNS)).double()
    rows[2000:, STRENGTH] = 1.0
    # Of the weak edgelets three in four lie within an object, of the strong ones one in five.
    within = torch.cat([torch.arange(2000) % 4 > 0, torch.arange(2000) % 5 == 0])
    trees, _ = boosted(rows, within, StagePlan(0.5, trees=30, leaves=2), seed=0)
    assert BoostedStage(0.5, trees)(rows[[0, -1]]).tolist() == pytest.approx([0.75, 0.2], abs=0.01)


def test_no_edgelets_need_no_judgement(merging: StagedMerging) -> None:
    assert merging.stages[0](torch.empty(0, len(APPEARANCE_COLUMNS)).double()).shape == (0,)


def test_what_was_saved_comes_back_and_segments_the_same(merging: StagedMerging, file: Path) -> None:
    again = load_stages(file)
    assert again == merging
    observation = picture(STACK).observation
    save_stages(file.with_name("twice.json"), again)
    assert file.with_name("twice.json").read_bytes() == file.read_bytes()
    one = silberman(file)(observation).label
    assert torch.equal(one, silberman(file.with_name("twice.json"))(observation).label)
    assert 0 < int(one.max()) < int(observation.fine.max())


def test_settings_tell_stages_apart_in_few_letters(merging: StagedMerging) -> None:
    other = StagedMerging("released", merging.stages, {"images": 3})
    fewer = StagedMerging("fixed", merging.stages[:1], {"images": 3})
    assert len({str(merging), str(other), str(fewer)}) == 3
    assert len(str(merging)) < 40


def test_the_file_is_text_and_its_trees_are_lightgbms(file: Path) -> None:
    record = json.loads(file.read_text())
    assert record["columns"] == list(APPEARANCE_COLUMNS)
    assert all(stage["trees"].startswith("tree\nversion=") for stage in record["stages"])


def test_stages_that_come_with_the_package_are_found_by_name(merging: StagedMerging) -> None:
    shipped = load_stages("silberman")
    assert [stage.threshold for stage in shipped.stages] == [0.9, 0.8, 0.7, 0.7, 0.7]
    assert shipped.variant == "fixed"


@pytest.mark.parametrize("name", ["nowhere", "nowhere.json"])
def test_a_missing_file_is_named_with_what_to_do(tmp_path: Path, name: str) -> None:
    with pytest.raises(CheckpointError, match=rf"{name}.* is not there; train it with"):
        load_stages(name if "." not in name else tmp_path / name)


def _without(key: str) -> Callable[[dict[str, Any]], Any]:
    return lambda record: record.pop(key)


def _with(key: str, value: object) -> Callable[[dict[str, Any]], Any]:
    return lambda record: record.update({key: value})


@pytest.mark.parametrize(
    ("spoil", "said"),
    [
        (_without("sha256"), "sha256"),
        (_without("stages"), "stages"),
        (_with("format", 2), "format 1"),
        (_with("columns", ["strength"]), "other features"),
        (_with("variant", "improved"), "other features"),
        (_with("stages", [{"threshold": 0.9, "trees": "tree"}]), "checksum"),
        (_with("stages", [None]), "no stages"),
        (_with("stages", [{"threshold": 10**400, "trees": ""}]), "too large"),
        (_with("provenance", []), "provenance"),
    ],
)
def test_a_spoilt_file_is_refused_in_one_line(file: Path, spoil: Callable[[Any], Any], said: str) -> None:
    record = json.loads(file.read_text())
    spoil(record)
    file.write_text(json.dumps(record))
    with pytest.raises(CheckpointError, match=said) as caught:
        load_stages(file)
    assert file.name in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("text", ["", "[]", "null", "{", "[" * 100_000, "7"])
def test_what_is_no_record_is_refused_in_one_line(tmp_path: Path, text: str) -> None:
    (tmp_path / "a.json").write_text(text)
    with pytest.raises(CheckpointError, match=r"a\.json holds no stages"):
        load_stages(tmp_path / "a.json")


def test_trees_that_are_none_are_refused_before_an_image_is_seen(
    merging: StagedMerging, tmp_path: Path
) -> None:
    save_stages(tmp_path / "a.json", StagedMerging("fixed", (BoostedStage(0.9, "tree\nversion=v4\n"),), {}))
    with pytest.raises(CheckpointError, match=r"a\.json.*cannot be read"):
        load_stages(tmp_path / "a.json")
