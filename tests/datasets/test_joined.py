"""Several sets of scenes as one: every scene has a name of its own, and comes from its set."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest
import torch
from hydra.utils import instantiate

from blockstab.datasets.cropped import CroppedScenes
from blockstab.datasets.joined import JoinedScenes
from blockstab.datasets.sets import FolderScenes
from blockstab.datasets.splits import Folds
from blockstab.simulation.cached import SimulatedScenes
from blockstab.testing.photographs import BLOCKS, photograph
from tests.docs.pages import composed
from tests.synthetic import write_folder


@pytest.fixture
def data(tmp_path: Path) -> JoinedScenes:
    """Two folders, each with a scene `a`, the second with one more."""
    for root, scene, blocks in (("few", "a", 1), ("many", "a", 3), ("many", "b-2", 4)):
        write_folder(photograph(*BLOCKS[:blocks]).frame, tmp_path / root / scene)
    return JoinedScenes({"few": FolderScenes(tmp_path / "few"), "many": FolderScenes(tmp_path / "many")})


def test_scenes_of_one_set_come_after_those_of_the_other_under_names_of_their_own(data):
    assert data.scenes() == ["few-a", "many-a", "many-b-2"]
    assert data.name == "few+many"


def test_every_scene_is_read_from_its_set(data):
    for scene, objects in (("few-a", 1), ("many-a", 3), ("many-b-2", 4)):
        frame, _ = data.read(scene)
        assert frame.name == scene
        assert len(frame.label.unique()) == 1 + objects + int(bool((frame.label == 0).any()))
        key, own = scene.split("-", 1)
        assert torch.equal(frame.depth, data.sets[key].read(own)[0].depth)


def test_the_stamp_is_that_of_the_scene_and_of_no_other(data):
    before = {scene: data.stamp(scene) for scene in data.scenes()}
    assert len(set(before.values())) == 3
    (Path(data.sets["many"].root) / "a" / "color.png").write_bytes(b"other")
    after = {scene: data.stamp(scene) for scene in data.scenes()}
    assert {scene for scene in before if before[scene] != after[scene]} == {"many-a"}


def test_joined_scenes_can_be_split(data):
    parts = Folds(count=3)(data)
    assert sorted(scene for k in range(3) for scene in parts[f"test{k}"]) == data.scenes()
    assert data.official() == {}


@pytest.mark.parametrize("names", [(), ("",), ("few", "very-many")])
def test_short_names_that_cannot_be_told_from_scenes_are_refused(data, names):
    with pytest.raises(ValueError, match="short names without '-', one at least") as caught:
        replace(data, sets=dict.fromkeys(names, data.sets["few"]))
    assert "\n" not in str(caught.value)


def test_the_configured_mixture_is_of_sets_that_are_all_different():
    mixed = instantiate(composed("train", ["data=mixed"]).data)
    assert (type(mixed), mixed.share) == (CroppedScenes, 0.5)
    sets = mixed.whole.sets.values()
    assert {type(data) for data in sets} == {SimulatedScenes}
    assert len({data.name for data in sets}) == len(sets) == 8
    assert sum(data.count for data in sets) == 320
