"""What every proposal must keep to."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import fields, replace
from functools import partial
from pathlib import Path

import numpy as np
import pytest
import torch

from blockstab.proposals import Proposal
from blockstab.proposals.felzenszwalb import Felzenszwalb
from blockstab.proposals.files import LabelFile, MaskFile
from blockstab.proposals.plane_dbscan import PlaneDBSCAN
from blockstab.proposals.plane_pieces import Planes
from blockstab.proposals.watershed import Watershed
from models.stages.stages import silberman
from tests.block_scene import APART, STACK, Picture, picture
from tests.proposals.mask_files import write_arrays, write_coco, write_labels, write_sam


def _from(file: str, write: Callable[..., None], folder: Path) -> MaskFile:
    """What a segmenter wrote that saw the stack: its blocks, which overlap, and a mask around both."""
    label = picture(STACK).frame.label
    assert label is not None
    lower, upper = (label == 2).numpy(), (label == 3).numpy()
    masks = [lower | np.roll(lower, 3, axis=1), upper, lower | upper]
    scores = () if write is write_labels else ((0.8, 0.7, 0.9),)
    write(folder / file, masks, *scores)
    return MaskFile(folder / file)


PROPOSALS: dict[str, Callable[[Path], Proposal]] = {
    "watershed": lambda _: Watershed(),
    "felzenszwalb": lambda _: Felzenszwalb(),
    "planes": lambda _: Planes(),
    "plane_dbscan": lambda _: PlaneDBSCAN(),
    "silberman": lambda _: silberman(),
    "scene_labels": lambda _: LabelFile(),
    "label_image": partial(_from, "ids.png", write_labels),
    "coco": partial(_from, "coco.json", write_coco),
    "sam": partial(_from, "sam.json", write_sam),
    "arrays": partial(_from, "masks.npz", write_arrays),
}


@pytest.fixture(params=PROPOSALS)
def proposal(request: pytest.FixtureRequest, tmp_path: Path) -> Proposal:
    return PROPOSALS[request.param](tmp_path)


@pytest.fixture(params=["apart", "stack", "table_only", "no_ground"])
def scene(request: pytest.FixtureRequest) -> Picture:
    blocks = {"apart": APART, "table_only": ()}.get(request.param, STACK)
    made = picture(blocks)
    return replace(made, ground=replace(made.ground, height=None)) if request.param == "no_ground" else made


def test_convention_label_image(proposal: Proposal, scene: Picture) -> None:
    label = proposal(scene.observation).label
    assert label.dtype == torch.int64
    assert label.shape == scene.frame.depth.shape
    assert int(label.min()) >= 0
    assert bool((label > 0).any())


def test_the_same_picture_gives_the_same_regions(proposal: Proposal, scene: Picture) -> None:
    one = proposal(scene.observation)
    other = proposal(scene.observation)
    assert torch.equal(one.label, other.label)
    assert one.is_background == other.is_background
    assert one.scores == other.scores


def test_what_is_known_is_known_of_regions_that_exist(proposal: Proposal, scene: Picture) -> None:
    proposed = proposal(scene.observation)
    there = set(proposed.label.unique().tolist()) - {0}
    assert set(proposed.is_background) <= there
    assert set(proposed.scores) <= there


def test_nothing_it_is_given_changes(proposal: Proposal, scene: Picture) -> None:
    before = [getattr(part, f.name) for part in (scene.frame, scene.cloud) for f in fields(part)]
    copies = [value.clone() if torch.is_tensor(value) else value for value in before]
    proposal(scene.observation)
    for value, copy in zip(before, copies, strict=True):
        assert torch.equal(value, copy) if torch.is_tensor(value) else value == copy
