"""What is concluded of a parse: as it was seen, or completed."""

from __future__ import annotations

import torch

from blockstab.scene.completion import Verdict
from blockstab.scene.conclusions import AsSeen, WhatStands
from tests.search.watched import blocks_view
from tests.synthetic import builder, variants

SEARCH_INPUT = blocks_view()
BUILD = builder(SEARCH_INPUT)
SCENES = BUILD(variants(SEARCH_INPUT, 4))


def test_as_seen_is_the_scene_of_the_search():
    for scene in SCENES:
        found = AsSeen()(scene, BUILD)
        assert found.scene is scene
        told = [verdict in (Verdict.STABLE, Verdict.BACKGROUND) for verdict in found.verdict]
        assert told == scene.balance.stable.tolist()


def test_completed_boxes_hold_all_that_was_seen():
    for scene in SCENES:
        found = WhatStands()(scene, BUILD)
        whole = found.scene.boxes
        reach = (found.seen.face_centers() - whole.center[:, None]) * whole.face_normals()
        half = whole.half_extent.repeat_interleave(2, dim=1)
        assert bool((reach.sum(dim=-1) <= half + 1e-9).all())
        assert torch.equal(whole.rotation, found.seen.rotation)


def test_verdicts_are_those_of_the_scene():
    for scene in SCENES:
        found = WhatStands()(scene, BUILD)
        told = [verdict != Verdict.UNSTABLE for verdict in found.verdict]
        assert told == found.scene.balance.stable.tolist()
        assert len(found.scene.pairs.gap) == len(scene.pairs.gap)
