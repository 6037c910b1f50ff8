"""Splits are drawn once, share nothing, and are what their file says."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from blockstab.datasets.splits import Folds, Halves, Official, Whole, scenes_of
from tests.datasets.scene_names import Names

TWENTY = Names(tuple(f"scene{i:02d}" for i in range(20)))


@pytest.mark.parametrize("amount", [20, 7, 2])
def test_halves_share_no_scene_and_leave_none_out(amount: int) -> None:
    data = Names(TWENTY.names[:amount])
    parts = Halves(seed=3)(data)
    assert set(parts) == {"train", "test"}
    assert sorted([*parts["train"], *parts["test"]]) == data.scenes()
    assert abs(len(parts["train"]) - len(parts["test"])) <= 1


def test_another_seed_halves_another_way_and_the_same_seed_the_same() -> None:
    assert Halves(seed=1)(TWENTY) == Halves(seed=1)(TWENTY)
    assert Halves(seed=1)(TWENTY) != Halves(seed=2)(TWENTY)


def test_every_scene_is_tested_in_exactly_one_fold_and_trains_in_the_others() -> None:
    parts = Folds(count=4, seed=1)(TWENTY)
    tested = [scene for i in range(4) for scene in parts[f"test{i}"]]
    assert sorted(tested) == TWENTY.scenes()
    for i in range(4):
        assert sorted([*parts[f"train{i}"], *parts[f"test{i}"]]) == TWENTY.scenes()


def test_neighbours_that_belong_together_are_never_parted() -> None:
    data = Names(TWENTY.names[:18])
    parts = Folds(count=3, seed=5, together=4)(data)
    runs = [data.scenes()[i : i + 4] for i in range(0, 18, 4)]
    for run in runs:
        assert sum(set(run) <= set(parts[f"test{i}"]) for i in range(3)) == 1


@pytest.mark.parametrize(
    "split", [Folds(count=4, together=7), Folds(count=1), Halves(together=0), Folds(count=21)]
)
def test_parts_that_cannot_be_filled_are_refused(split: Folds | Halves) -> None:
    with pytest.raises(ValueError, match=r"names has 20 scenes, which .* parts cannot share"):
        split(TWENTY)


def test_the_official_split_is_the_set_s_own_and_its_absence_is_said() -> None:
    data = Names(("a", "b"), parts={"train": ["b"], "test": ["a"]})
    assert Official()(data) == {"train": ["b"], "test": ["a"]}
    with pytest.raises(ValueError, match="No split came with names"):
        Official()(TWENTY)


def test_a_split_is_kept_and_read_again_even_if_the_draw_would_be_another(tmp_path: Path) -> None:
    kept_in = tmp_path / "not" / "there yet"
    first = scenes_of(TWENTY, Halves(seed=1), "train", kept_in)
    (file,) = kept_in.iterdir()
    assert file.name == "names_halves_seed1_together1.json"
    kept = json.loads(file.read_text())
    assert kept["parts"]["train"] == first
    kept["parts"]["train"] = first[:3]
    file.write_text(json.dumps(kept))
    assert scenes_of(TWENTY, Halves(seed=1), "train", kept_in) == first[:3]


def test_a_kept_split_of_other_scenes_is_refused_by_the_name_of_its_file(tmp_path: Path) -> None:
    scenes_of(TWENTY, Whole(), "all", tmp_path)
    with pytest.raises(
        ValueError, match=r"names_whole\.json: it must name scenes of names, but 'scene19' is none"
    ):
        scenes_of(Names(TWENTY.names[:19]), Whole(), "all", tmp_path)


def test_a_part_that_is_not_there_is_named_with_those_that_are(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match=r"no scenes in part 'all'; choose from \['train', 'test'\]"):
        scenes_of(TWENTY, Halves(), "all", tmp_path)


@pytest.mark.parametrize(
    "text", ["", "[]", '{"parts": 3}', '{"parts": {"train": [1]}}', '{"parts": {"train": "a"}}']
)
def test_a_damaged_split_file_is_one_line(tmp_path: Path, text: str) -> None:
    (tmp_path / "names_whole.json").write_text(text)
    with pytest.raises(ValueError, match=r"names_whole\.json"):
        scenes_of(TWENTY, Whole(), "all", tmp_path)


@pytest.mark.parametrize("name", ["x" * 1000, "two\nlines", "\0"])
def test_a_strange_name_in_a_split_file_stays_a_short_line(tmp_path: Path, name: str) -> None:
    (tmp_path / "names_whole.json").write_text(json.dumps({"parts": {"all": [name], name: []}}))
    for part in ("all", "test"):
        with pytest.raises(ValueError, match=r"names_whole\.json") as caught:
            scenes_of(TWENTY, Whole(), part, tmp_path)
        assert str(caught.value).isprintable()
        assert len(str(caught.value)) < len(str(tmp_path)) + 200


def test_a_set_s_name_with_slashes_and_spaces_stays_in_the_folder(tmp_path: Path) -> None:
    scenes_of(Names(("a",), name="../osd (annotated)"), Whole(), "all", tmp_path)
    assert [f.name for f in tmp_path.iterdir()] == ["..-osd_(annotated)_whole.json"]


def test_sets_whose_names_are_longer_than_a_file_s_keep_a_file_each(tmp_path: Path) -> None:
    for last in "ab":
        joined = Names(("a",), name="+".join(["a_long_name_of_a_set"] * 20 + [last]))
        assert scenes_of(joined, Whole(), "all", tmp_path) == ["a"]
    assert len(list(tmp_path.iterdir())) == 2
