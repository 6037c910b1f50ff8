"""Scenes beside each other answer as each of them by itself."""

from __future__ import annotations

import pytest
import torch

from blockstab.features.pairwise import box_features, neighbour_pairs, pairs_of
from blockstab.features.unary import unary_features
from blockstab.scene.beside import beside
from blockstab.scene.types import Scene
from blockstab.stability.support import GROUND
from blockstab.testing import worlds
from tests.box_scene import scene_of

SCENES = [scene_of(*blocks) for blocks in (worlds.STACK, worlds.BRIDGE, worlds.TENT, worlds.COUNTERWEIGHT)]


@pytest.mark.parametrize("features", [unary_features, box_features])
def test_features_are_those_of_every_scene_by_itself(features):
    assert torch.equal(features(beside(SCENES)), torch.cat([features(scene) for scene in SCENES]))


def test_pairs_are_those_of_every_scene_by_itself():
    assert pairs_of(beside(SCENES)) == [pair for scene in SCENES for pair in pairs_of(scene)]


def test_the_ground_supports_what_it_did():
    def on_ground(scene: Scene) -> list[int]:
        return scene.supports.supported[scene.supports.supporter == GROUND].tolist()

    sizes = [0, *torch.tensor([len(scene) for scene in SCENES]).cumsum(0).tolist()]
    apart = [i + start for scene, start in zip(SCENES, sizes, strict=False) for i in on_ground(scene)]
    assert sorted(on_ground(beside(SCENES))) == sorted(apart)


def test_no_pair_and_no_support_joins_two_scenes():
    one = beside(SCENES)
    scene_of_box = torch.arange(len(SCENES)).repeat_interleave(torch.tensor(list(map(len, SCENES))))
    boxes_only = one.supports.supporter != GROUND
    ends = [
        (one.pairs.first, one.pairs.second),
        neighbour_pairs(one),
        (one.supports.supporter[boxes_only], one.supports.supported[boxes_only]),
    ]
    for first, second in ends:
        assert torch.equal(scene_of_box[first], scene_of_box[second])
