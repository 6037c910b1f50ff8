"""Masks from JSON, as COCO and Segment Anything write it."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from blockstab.proposals.annotations import annotated_masks
from blockstab.proposals.masks import Mask
from blockstab.rgbd.reading import FrameError
from tests.proposals.mask_files import SMALL, nested, write_coco, write_sam

SCORES = (0.9, 0.8, 0.95)
EMPTY = {"size": [*SMALL], "counts": [SMALL[0] * SMALL[1]]}


def read(path: Path, values: Any) -> list[Mask]:
    path.write_text(json.dumps(values))
    return list(annotated_masks(path, *SMALL))


@pytest.fixture
def path(tmp_path: Path) -> Path:
    return tmp_path / "masks.json"


@pytest.mark.parametrize("kind", ["coco", "lists", "sam"])
def test_masks_and_scores_come_back(path: Path, kind: str) -> None:
    if kind == "sam":
        write_sam(path, nested(), SCORES)
    else:
        write_coco(path, nested(), SCORES, compressed=kind == "coco")
    masks = list(annotated_masks(path, *SMALL))
    assert [(mask.number, mask.score) for mask in masks] == [(1, 0.9), (2, 0.8), (3, 0.95)]
    for mask, expected in zip(masks, nested(), strict=True):
        assert np.array_equal(mask.inside, expected)


def test_a_mask_need_not_have_a_score(path: Path) -> None:
    assert read(path, [{"segmentation": EMPTY}])[0].score is None


def test_a_file_may_hold_no_masks(path: Path) -> None:
    assert read(path, []) == read(path, {"annotations": []}) == []


@pytest.mark.parametrize(
    "values", [{}, 3, "masks", None, {"annotations": {}}, [[]], [3], {"annotations": [None]}]
)
def test_what_is_no_list_of_objects_is_refused(path: Path, values: Any) -> None:
    with pytest.raises(
        FrameError, match=r"masks\.json: must be a list of objects, or an object with such a list"
    ):
        read(path, values)


def test_what_is_no_json_is_refused(path: Path) -> None:
    path.write_bytes(b"[{]")
    with pytest.raises(FrameError, match=r"masks\.json: must be JSON"):
        list(annotated_masks(path, *SMALL))


def test_masks_of_several_images_are_refused(path: Path) -> None:
    with pytest.raises(FrameError, match="masks of one image, but has those of 2"):
        read(path, [{"image_id": 1, "segmentation": EMPTY}, {"image_id": 2, "segmentation": EMPTY}])


@pytest.mark.parametrize("score", [float("nan"), float("inf"), "high", None, True, [1.0], 10**400])
def test_a_score_is_a_finite_number(path: Path, score: Any) -> None:
    with pytest.raises(FrameError, match=r"masks\.json: mask 2: predicted_iou must be a finite number"):
        read(path, [{"segmentation": EMPTY}, {"segmentation": EMPTY, "predicted_iou": score}])


def test_a_bad_mask_is_named_by_its_place(path: Path) -> None:
    with pytest.raises(FrameError, match=r"masks\.json: mask 2: size must be that of the image, \[30, 40\]"):
        read(path, [{"segmentation": EMPTY}, {"segmentation": {"size": [40, 30], "counts": [1200]}}])


def test_polygons_are_refused_by_name(path: Path) -> None:
    with pytest.raises(FrameError, match="run lengths, an object with size and counts, but it is polygons"):
        read(path, [{"segmentation": [[1, 1, 5, 1, 5, 5]]}])


def test_more_masks_than_the_limit_are_refused_before_any_is_read(path: Path) -> None:
    with pytest.raises(FrameError, match="at most 4096 masks"):
        read(path, [{}] * 4097)
