"""Scene folders as a set."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest
import torch

from blockstab.datasets.folder import write_scene
from blockstab.datasets.sets import FolderScenes
from blockstab.datasets.truth import Truth
from blockstab.testing.photographs import BLOCKS, photograph

FRAME = photograph(*BLOCKS).frame
PLAIN = Truth((1,), (), None, False)


@pytest.fixture
def root(tmp_path: Path) -> Path:
    """Two scenes, of which the second has annotated supports."""
    write_scene(tmp_path / "a", FRAME, PLAIN, {})
    write_scene(tmp_path / "b", FRAME, replace(PLAIN, support_annotated=True), {})
    return tmp_path


def test_a_scene_is_read_by_its_name(root: Path) -> None:
    data = FolderScenes(root)
    assert data.scenes() == ["a", "b"]
    frame, truth = data.read("b")
    assert frame.name == "b"
    assert torch.equal(frame.depth, FRAME.depth)
    assert truth.support_annotated


def test_annotated_scenes_are_those_that_say_so_and_those_that_cannot_be_read(root: Path) -> None:
    assert FolderScenes(root, annotated=True).scenes() == ["b"]
    (root / "a" / "meta.json").write_text("{")
    assert FolderScenes(root, annotated=True).scenes() == ["a", "b"]


@pytest.mark.parametrize("file", ["color.png", "depth.png", "label.png", "meta.json", "boundary.png"])
def test_the_stamp_changes_with_every_file_and_with_nothing_else(root: Path, file: str) -> None:
    data = FolderScenes(root)
    before = data.stamp("a")
    (root / "a" / "notes.txt").write_text("mine")
    assert data.stamp("a") == before
    (root / "a" / file).write_bytes(b"other")
    assert data.stamp("a") != before


def test_a_folder_without_scenes_is_refused(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="holds no scene folder"):
        FolderScenes(tmp_path).scenes()
