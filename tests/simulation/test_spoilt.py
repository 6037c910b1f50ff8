"""Spoilt scenes do not stand, and say so."""

from __future__ import annotations

import pytest

from blockstab.datasets.folder import read_truth, write_scene
from blockstab.simulation.simulated import simulate_scene
from blockstab.simulation.spoilt import LetGo, SpoiltScenes, WithoutSupport, spoilt

pytest.importorskip("mujoco", reason="the extra `sim` is not installed")


@pytest.mark.parametrize("recipe", [WithoutSupport(seed=3), LetGo(seed=3)])
def test_something_in_a_spoilt_scene_moves_and_the_file_says_what(recipe, tmp_path):
    frame, truth = simulate_scene(recipe, 0)
    assert any(o.moves for o in truth.objects)
    assert all(o.supported_by is None and o.falls_if_removed is None for o in truth.objects)
    assert not truth.support_annotated
    write_scene(tmp_path / "scene", frame, truth, {})
    again = read_truth(tmp_path / "scene")
    assert [o.moves for o in again.objects] == [o.moves for o in truth.objects]


def test_only_blocks_are_let_go():
    with pytest.raises(ValueError, match="Only blocks"):
        LetGo(preset="grocery")


def test_an_unknown_way_is_refused_by_name():
    with pytest.raises(ValueError, match="support, let_go"):
        spoilt("burnt")


def test_sets_of_either_kind_have_names_of_their_own(tmp_path):
    names = {SpoiltScenes(way=way, cache=tmp_path).name for way in ("support", "let_go")}
    assert len(names) == 2
