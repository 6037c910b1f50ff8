"""Regions that somebody else made."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import torch
from numpy.typing import NDArray
from PIL import Image

from blockstab.proposals.files import LabelFile, MaskFile
from tests.block_scene import APART, TABLE, Picture, picture
from tests.proposals.mask_files import write_arrays, write_coco, write_labels, write_sam

BLOCK, OTHER = 2, 3  # labels of the blocks
SCORES = (0.9, 0.8, 0.7)


@pytest.fixture(scope="module")
def scene() -> Picture:
    return picture(APART)


@pytest.fixture
def masks(scene: Picture) -> list[NDArray[np.bool_]]:
    """A block, the left half of it, and the other block; the table is in none."""
    assert scene.frame.label is not None
    label = scene.frame.label.numpy()
    middle = int(np.median(np.flatnonzero((label == BLOCK).any(axis=0))))
    half = (label == BLOCK) & (np.arange(label.shape[1]) < middle)
    return [label == BLOCK, half, label == OTHER]


def test_the_labels_of_the_scene_keep_their_ids_and_background(scene: Picture) -> None:
    proposed = LabelFile()(scene.observation)
    assert torch.equal(proposed.label, scene.frame.label)
    assert dict(proposed.is_background) == {TABLE: True, 2: False, 3: False}


def test_a_scene_without_labels_is_refused_by_name(scene: Picture) -> None:
    with pytest.raises(ValueError, match=r"blocks has no label\.png"):
        LabelFile()(replace(scene, frame=replace(scene.frame, label=None)).observation)


WRITERS: dict[str, Callable[..., None]] = {
    "coco.json": write_coco,
    "sam.json": write_sam,
    "masks.npz": write_arrays,
}


@pytest.mark.parametrize("name", WRITERS)
def test_what_a_segmenter_wrote_becomes_regions_with_scores(
    scene: Picture, masks: list[NDArray[np.bool_]], tmp_path: Path, name: str
) -> None:
    WRITERS[name](tmp_path / name, masks, SCORES)
    proposed = MaskFile(tmp_path / name)(scene.observation)
    whole, half, other = (torch.from_numpy(mask) for mask in masks)
    assert torch.equal(proposed.label == 1, whole & ~half)
    assert torch.equal(proposed.label == 2, half)
    assert torch.equal(proposed.label == 3, other)
    assert dict(proposed.scores) == pytest.approx({1: 0.9, 2: 0.8, 3: 0.7})


def test_the_table_that_is_in_no_mask_is_one_region_known_as_background(
    scene: Picture, masks: list[NDArray[np.bool_]], tmp_path: Path
) -> None:
    write_coco(tmp_path / "a.json", masks, SCORES)
    observation = scene.observation
    proposed = MaskFile(tmp_path / "a.json")(observation)
    covered = torch.from_numpy(np.any(masks, axis=0))
    assert dict(proposed.is_background) == {4: True}
    assert torch.equal(proposed.label == 4, observation.on_ground & ~covered)
    assert torch.equal(proposed.label == 0, ~observation.on_ground & ~covered)


def test_an_object_in_no_mask_has_no_region(
    scene: Picture, masks: list[NDArray[np.bool_]], tmp_path: Path
) -> None:
    write_coco(tmp_path / "a.json", masks[:2], SCORES[:2])
    label = MaskFile(tmp_path / "a.json")(scene.observation).label
    high = torch.from_numpy(masks[2]) & ~scene.observation.on_ground
    assert int(high.sum()) > 0.9 * masks[2].sum()
    assert not bool(label[high].any())


def test_a_few_pixels_of_the_table_are_no_region(
    scene: Picture, masks: list[NDArray[np.bool_]], tmp_path: Path
) -> None:
    observation = scene.observation
    rows, columns = np.nonzero(observation.on_ground.numpy() & ~np.any(masks, axis=0))
    covered = np.ones_like(masks[0])
    covered[rows[:99], columns[:99]] = False
    write_coco(tmp_path / "a.json", [covered, *masks], (0.5, *SCORES))
    proposed = MaskFile(tmp_path / "a.json")(observation)
    assert torch.equal(proposed.label > 0, torch.from_numpy(covered))
    assert torch.equal(
        MaskFile(tmp_path / "a.json", least_px=99)(observation).label == 5, torch.from_numpy(~covered)
    )


def test_what_is_left_of_a_mask_on_the_table_becomes_table(
    scene: Picture, masks: list[NDArray[np.bool_]], tmp_path: Path
) -> None:
    observation = scene.observation
    rows, columns = np.nonzero(observation.on_ground.numpy() & ~np.any(masks, axis=0))
    wide = masks[0].copy()
    wide[rows[:30], columns[:30]] = True
    write_coco(tmp_path / "a.json", [wide, masks[0]], SCORES[:2])
    proposed = MaskFile(tmp_path / "a.json")(observation)
    assert set(proposed.label[rows[:30], columns[:30]].tolist()) == {3}
    assert dict(proposed.is_background) == {3: True}


def test_a_mask_of_the_table_is_known_as_background(
    scene: Picture, masks: list[NDArray[np.bool_]], tmp_path: Path
) -> None:
    everywhere = np.ones_like(masks[0])
    write_coco(tmp_path / "a.json", [everywhere, *masks], (0.5, *SCORES))
    proposed = MaskFile(tmp_path / "a.json")(scene.observation)
    assert dict(proposed.is_background) == {1: True}
    assert bool((proposed.label > 0).all())


def test_unsure_masks_are_left_out_and_those_without_score_are_not(
    scene: Picture, masks: list[NDArray[np.bool_]], tmp_path: Path
) -> None:
    write_coco(tmp_path / "a.json", masks, (0.9, 0.3, 0.5))
    proposed = MaskFile(tmp_path / "a.json", least_score=0.5)(scene.observation)
    assert torch.equal(proposed.label == 1, torch.from_numpy(masks[0]))
    assert set(proposed.scores) == {1, 3}
    np.savez(tmp_path / "a.npz", masks=np.stack(masks))
    assert set(MaskFile(tmp_path / "a.npz", least_score=0.5)(scene.observation).label.unique().tolist()) >= {
        1,
        2,
        3,
    }


def test_a_small_mask_leaves_no_hole_in_the_larger_one(
    scene: Picture, masks: list[NDArray[np.bool_]], tmp_path: Path
) -> None:
    speck = np.zeros_like(masks[0])
    rows, columns = np.nonzero(masks[0])
    speck[rows[:50], columns[:50]] = True
    write_coco(tmp_path / "a.json", [masks[0], speck], (0.9, 0.99))
    proposed = MaskFile(tmp_path / "a.json", least_px=51)(scene.observation)
    assert torch.equal(proposed.label == 1, torch.from_numpy(masks[0]))
    assert set(proposed.scores) == {1}


def test_what_others_leave_of_a_mask_is_no_region_if_it_is_small(
    scene: Picture, masks: list[NDArray[np.bool_]], tmp_path: Path
) -> None:
    rows, columns = np.nonzero(masks[0])
    part = masks[0].copy()
    part[rows[:30], columns[:30]] = False
    write_coco(tmp_path / "a.json", [masks[0], part], (0.9, 0.8))
    proposed = MaskFile(tmp_path / "a.json", least_px=31)(scene.observation)
    assert torch.equal(proposed.label == 2, torch.from_numpy(part))
    assert set(proposed.scores) == {2}
    assert not bool((proposed.label == 1).any())


@pytest.mark.parametrize(("kind", "largest"), [("uint8", 255), ("uint16", 65535)])
def test_a_label_image_keeps_its_ids(scene: Picture, tmp_path: Path, kind: str, largest: int) -> None:
    ids = np.zeros(scene.frame.depth.shape, dtype=kind)
    ids[5:20, 5:30], ids[30:40, 5:30] = 17, largest
    path = tmp_path / "ids.png"
    Image.fromarray(ids).save(path)
    proposed = MaskFile(path)(scene.observation)
    given = torch.from_numpy(ids.astype(np.int64))
    assert torch.equal(torch.where(given > 0, proposed.label, 0), given)
    assert proposed.scores == {}


def test_a_path_takes_the_name_of_the_scene(
    scene: Picture, masks: list[NDArray[np.bool_]], tmp_path: Path
) -> None:
    (tmp_path / "blocks").mkdir()
    write_labels(tmp_path / "blocks" / "blocks_ids.png", masks)
    proposal = MaskFile(f"{tmp_path}/{{scene}}/{{scene}}_ids.png")
    assert proposal.file("blocks") == tmp_path / "blocks" / "blocks_ids.png"
    assert {1, 2, 3} <= set(proposal(scene.observation).label.unique().tolist())


def test_a_file_of_another_size_is_refused(scene: Picture, tmp_path: Path) -> None:
    small = [np.ones((10, 20), dtype=bool)]
    write_labels(tmp_path / "small.png", small)
    write_coco(tmp_path / "small.json", small, (0.9,))
    write_arrays(tmp_path / "small.npz", small, (0.9,))
    with pytest.raises(ValueError, match="320 x 240 pixels of blocks, but has 20 x 10"):
        MaskFile(tmp_path / "small.png")(scene.observation)
    with pytest.raises(ValueError, match=r"that of the image, \[240, 320\] .* but it is \[10, 20\]"):
        MaskFile(tmp_path / "small.json")(scene.observation)
    with pytest.raises(ValueError, match="N x 240 x 320, as the image is, but are 1 x 10 x 20"):
        MaskFile(tmp_path / "small.npz")(scene.observation)


def test_a_picture_in_colour_is_no_label_image(scene: Picture, tmp_path: Path) -> None:
    path = tmp_path / "color.png"
    Image.fromarray(scene.frame.color.numpy()).save(path)
    with pytest.raises(ValueError, match="one channel"):
        MaskFile(path)(scene.observation)


@pytest.mark.parametrize("name", ["nowhere.png", "nowhere.json", "nowhere.npz"])
def test_a_missing_file_is_named(scene: Picture, tmp_path: Path, name: str) -> None:
    with pytest.raises(ValueError, match=name.replace(".", r"\.")):
        MaskFile(tmp_path / name)(scene.observation)


@pytest.mark.parametrize("path", ["masks.pkl", "masks", "masks.JSON.gz"])
def test_a_file_of_another_kind_is_refused_at_once(path: str) -> None:
    with pytest.raises(ValueError, match=r"must be a \.png, \.json or \.npz file"):
        MaskFile(path)
