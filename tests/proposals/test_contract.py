"""What every proposal must keep to."""

from __future__ import annotations

from dataclasses import fields, replace
from pathlib import Path

import pytest
import torch
from PIL import Image

from blockstab.proposals import Proposal
from blockstab.proposals.felzenszwalb import Felzenszwalb
from blockstab.proposals.files import LabelFile
from blockstab.proposals.watershed import Watershed
from tests.block_scene import APART, STACK, Picture, picture

NAMES = ["watershed", "felzenszwalb", "scene_labels", "label_file"]


@pytest.fixture(params=NAMES)
def proposal(request: pytest.FixtureRequest, tmp_path: Path) -> Proposal:
    path = tmp_path / "regions.png"
    Image.fromarray((picture(STACK).frame.label * 300).numpy().astype("uint16")).save(path)
    choices = [Watershed(), Felzenszwalb(), LabelFile(), LabelFile(path)]
    return dict(zip(NAMES, choices, strict=True))[request.param]


@pytest.fixture(params=["apart", "stack", "table_only", "no_ground"])
def scene(request: pytest.FixtureRequest) -> Picture:
    blocks = {"apart": APART, "table_only": ()}.get(request.param, STACK)
    made = picture(blocks)
    return replace(made, ground=replace(made.ground, height=None)) if request.param == "no_ground" else made


def test_convention_label_image(proposal: Proposal, scene: Picture) -> None:
    label = proposal(scene.percept).label
    assert label.dtype == torch.int64
    assert label.shape == scene.frame.depth.shape
    assert int(label.min()) >= 0
    assert bool((label > 0).any())


def test_the_same_picture_gives_the_same_regions(proposal: Proposal, scene: Picture) -> None:
    one = proposal(scene.percept)
    other = proposal(scene.percept)
    assert torch.equal(one.label, other.label)
    assert one.known == other.known


def test_what_is_known_is_known_of_regions_that_exist(proposal: Proposal, scene: Picture) -> None:
    proposed = proposal(scene.percept)
    assert set(proposed.known) <= set(proposed.label.unique().tolist()) - {0}


def test_nothing_it_is_given_changes(proposal: Proposal, scene: Picture) -> None:
    before = [getattr(part, f.name) for part in (scene.frame, scene.cloud) for f in fields(part)]
    copies = [value.clone() if torch.is_tensor(value) else value for value in before]
    proposal(scene.percept)
    for value, copy in zip(before, copies, strict=True):
        assert torch.equal(value, copy) if torch.is_tensor(value) else value == copy
