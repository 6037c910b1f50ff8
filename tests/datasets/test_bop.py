"""Sets in the BOP format, from a miniature."""

from __future__ import annotations

import copy
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch

from blockstab.datasets.bop import BOP
from blockstab.rgbd.frame import Camera
from blockstab.rgbd.reading import FrameError
from tests.datasets.bop_files import BEHIND, CAMERA, FRONT, MODELS, SAID, write_bop, write_json, write_png


@pytest.fixture
def root(tmp_path: Path) -> Path:
    write_bop(tmp_path)
    return tmp_path


def test_depth_is_in_metres_by_the_scale_of_the_image(root: Path) -> None:
    frame, _ = BOP(root).read("000003-000012")
    assert bool((frame.depth == 0.8).all())
    assert frame.camera == Camera(*CAMERA)
    assert bool((frame.color == 102).all())


def test_labels_are_the_visible_masks_in_the_order_of_the_objects(root: Path) -> None:
    frame, truth = BOP(root).read("000003-000000")
    expected = torch.zeros(30, 40, dtype=torch.int64)
    expected[FRONT], expected[BEHIND] = 1, 2
    assert frame.label is not None
    assert torch.equal(frame.label, expected)
    assert [(o.id, o.category, o.total_pixels) for o in truth.objects] == [
        (1, "obj_000005", 225),
        (2, "obj_000007", 300),
    ]


def test_a_box_is_the_models_bounding_box_where_the_model_is(root: Path) -> None:
    first, second = BOP(root).read("000003-000000")[1].objects
    assert first.half_extent is not None
    assert first.half_extent.tolist() == pytest.approx([0.02, 0.03, 0.04])
    # The middle of the model, (10, 10, 40) mm, turned by a quarter about z is (-10, 10, 40) mm.
    assert first.pose_camera is not None
    assert first.pose_camera[:3, 3].tolist() == pytest.approx([0.09, -0.04, 0.84])
    assert first.pose_camera[:3, 0].tolist() == pytest.approx([0.0, 1.0, 0.0])
    assert second.half_extent is None
    assert second.pose_camera is not None
    assert second.pose_camera[:3, 3].tolist() == pytest.approx([0.0, 0.0, 0.9])


def test_only_the_models_of_an_image_must_make_sense(root: Path) -> None:
    write_json(root / "models/models_info.json", {**MODELS, "8": None, "9" * 5000: None})
    assert BOP(root).read("000003-000000")[1].objects[0].half_extent is not None
    write_json(root / "models/models_info.json", {**MODELS, "5": {**MODELS["5"], "size_y": 0}})
    with pytest.raises(FrameError, match=r"models_info\.json: sizes of model '5' must be above 0"):
        BOP(root).read("000003-000000")


def test_greyscale_images_and_jpegs_do_as_well(root: Path) -> None:
    for old, new in (("rgb/000000.png", "gray/000000.jpg"), ("rgb/000012.png", "rgb/000012.jpg")):
        (root / "test/000003" / old).unlink()
        write_png(root / "test/000003" / new, np.full((30, 40), 77, dtype="u1"))
    for scene in BOP(root).scenes():
        assert bool((BOP(root).read(scene)[0].color == 77).all())


def test_an_object_that_another_hides_whole_is_not_there(root: Path) -> None:
    write_png(root / "test/000003/mask_visib/000000_000000.png", np.zeros((30, 40), dtype="u1"))
    assert [o.id for o in BOP(root).read("000003-000000")[1].objects] == [2]


def test_scenes_are_named_by_scene_and_image_and_none_is_an_error(root: Path) -> None:
    (root / "test/000003/depth/._000000.png").write_bytes(b"")  # as some systems leave beside each file
    assert BOP(root).scenes() == ["000003-000000", "000003-000012"]
    with pytest.raises(ValueError, match="holds no scene"):
        BOP(root, "train").scenes()


def changed(part: str, key: str, value: object) -> Any:
    said = copy.deepcopy(SAID[part])
    entry = said if isinstance(said, dict) else said[0]
    entry[key] = value
    return {"0": said}


@pytest.mark.parametrize(
    ("part", "value", "message"),
    [
        ("camera", {}, "must be a JSON object"),
        ("camera", changed("camera", "cam_K", [1.0]), "cam_K must be 9 finite numbers"),
        ("camera", changed("camera", "depth_scale", 0), "depth_scale must be above 0"),
        ("gt", changed("gt", "cam_R_m2c", [2.0] * 9), "cam_R_m2c must be a rotation"),
        ("gt", changed("gt", "cam_t_m2c", [0, 0, float("nan")]), "cam_t_m2c must be 3 finite numbers"),
        ("gt", changed("gt", "obj_id", "../5"), "obj_id must be a whole number"),
        ("gt", {"0": {"a": 1}}, "must have a list of objects"),
        ("gt_info", {"0": []}, "must have 2 objects, but has 0"),
    ],
)
def test_what_a_file_must_hold_is_said_in_one_line(
    root: Path, part: str, value: object, message: str
) -> None:
    write_json(root / f"test/000003/scene_{part}.json", value)
    with pytest.raises(FrameError, match=message) as caught:
        BOP(root).read("000003-000000")
    assert f"scene_{part}.json" in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_mask_that_is_missing_of_another_size_or_a_link_out_is_named(
    root: Path, tmp_path_factory: pytest.TempPathFactory
) -> None:
    mask = root / "test/000003/mask_visib/000000_000001.png"
    mask.unlink()
    with pytest.raises(FrameError, match="000000_000001"):
        BOP(root).read("000003-000000")
    write_png(mask, np.zeros((30, 41), dtype="u1"))
    with pytest.raises(FrameError, match="000000_000001"):
        BOP(root).read("000003-000000")
    outside = tmp_path_factory.mktemp("outside") / "mask.png"
    write_png(outside, np.zeros((30, 40), dtype="u1"))
    mask.unlink()
    mask.symlink_to(outside)
    with pytest.raises(FrameError, match="links out of it"):
        BOP(root).read("000003-000000")


def test_a_stamp_changes_with_any_mask(root: Path) -> None:
    before = BOP(root).stamp("000003-000000")
    write_png(root / "test/000003/mask_visib/000000_000001.png", np.zeros((30, 40), dtype="u1"))
    assert BOP(root).stamp("000003-000000") != before
