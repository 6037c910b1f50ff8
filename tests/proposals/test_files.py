"""Regions that somebody else made."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import torch
from PIL import Image

from blockstab.proposals.files import LabelFile
from tests.block_scene import APART, TABLE, Picture, picture


@pytest.fixture
def scene() -> Picture:
    return picture(APART)


def test_the_labels_of_the_scene_keep_their_ids_and_background(scene: Picture) -> None:
    proposed = LabelFile()(scene.percept)
    assert torch.equal(proposed.label, scene.frame.label)
    assert dict(proposed.known) == {TABLE: True, 2: False, 3: False}


def test_a_scene_without_labels_is_refused_by_name(scene: Picture) -> None:
    with pytest.raises(ValueError, match=r"blocks has no label\.png"):
        LabelFile()(replace(scene, frame=replace(scene.frame, label=None)).percept)


@pytest.mark.parametrize(("kind", "largest"), [("uint8", 255), ("uint16", 65535)])
def test_a_file_keeps_its_ids(scene: Picture, tmp_path: Path, kind: str, largest: int) -> None:
    ids = np.zeros(scene.frame.depth.shape, dtype=kind)
    ids[5:20, 5:30], ids[30:40, 5:30] = 17, largest
    path = tmp_path / "ids.png"
    Image.fromarray(ids).save(path)
    proposed = LabelFile(str(path))(scene.percept)
    assert torch.equal(proposed.label, torch.from_numpy(ids.astype(np.int64)))
    assert not proposed.known


def test_a_file_of_another_size_is_refused(scene: Picture, tmp_path: Path) -> None:
    path = tmp_path / "small.png"
    Image.fromarray(np.ones((10, 20), dtype=np.uint8)).save(path)
    with pytest.raises(ValueError, match="320 x 240 pixels of blocks, but has 20 x 10"):
        LabelFile(path)(scene.percept)


def test_a_picture_in_colour_is_no_label_image(scene: Picture, tmp_path: Path) -> None:
    path = tmp_path / "color.png"
    Image.fromarray(scene.frame.color.numpy()).save(path)
    with pytest.raises(ValueError, match="one channel"):
        LabelFile(path)(scene.percept)


def test_a_missing_file_is_named(scene: Picture, tmp_path: Path) -> None:
    with pytest.raises(ValueError, match=r"nowhere\.png"):
        LabelFile(tmp_path / "nowhere.png")(scene.percept)
