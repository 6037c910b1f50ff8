"""NYU Depth v2, from a miniature of its files."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import torch

from blockstab.datasets.nyu import LABELLED, SPLIT, SUPPORTS, NYUv2, regions
from blockstab.rgbd.reading import FrameError
from tests.datasets.nyu_files import color, depth, labels, write_nyu, write_supports


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Path:
    root = tmp_path_factory.mktemp("nyu")
    write_nyu(root)
    return root


@pytest.fixture
def root(whole: Path, tmp_path: Path) -> Path:
    for file in whole.iterdir():
        (tmp_path / file.name).write_bytes(file.read_bytes())
    return tmp_path


def test_images_are_those_stored_cropped_to_427_by_561(whole: Path) -> None:
    frame, _ = NYUv2(whole).read("nyu_0002")
    crop = (slice(44, 471), slice(40, 601))
    assert frame.depth.shape == (427, 561)
    np.testing.assert_array_equal(frame.color, color(1)[crop])
    np.testing.assert_array_equal(frame.depth, depth(1)[crop].astype(np.float64))


def test_the_camera_sees_a_point_in_the_crop_where_the_published_one_saw_it(whole: Path) -> None:
    camera = NYUv2(whole).read("nyu_0001")[0].camera
    x, y, z = 0.3, -0.2, 2.0
    # Published: pixels of the whole image, the first of which is number 1.
    u, v = 518.858 * x / z + 325.582, 519.470 * y / z + 253.736
    assert camera.fx * x / z + camera.cx == pytest.approx(u - 41)
    assert camera.fy * y / z + camera.cy == pytest.approx(v - 45)


def test_regions_are_numbered_by_class_then_instance_and_specks_are_none(whole: Path) -> None:
    frame, truth = NYUv2(whole).read("nyu_0001")
    classes, instances = (part[44:471, 40:601] for part in labels(0))
    assert frame.label is not None
    for number, (kind, own) in enumerate([(1, 1), (2, 1), (3, 1), (4, 1), (5, 1), (5, 2)], start=1):
        np.testing.assert_array_equal(frame.label == number, (classes == kind) & (instances == own))
    assert int(frame.label.max()) == 6
    assert not frame.label[(torch.from_numpy(classes == 5) & torch.from_numpy(instances == 3))].any()
    assert truth.background_ids == frame.background_ids == (2, 4)
    assert [(o.id, o.category) for o in truth.objects] == [(1, "book"), (3, "table"), (5, "cup"), (6, "cup")]


def test_a_region_of_ten_pixels_counts_and_one_of_nine_does_not() -> None:
    classes = np.zeros((5, 8), dtype="u2")
    classes[:2, :5], classes[3:, :4], classes[4, 7] = 7, 3, 3
    label, of_region = regions(classes, np.zeros((5, 8), dtype="u1"))
    assert of_region == [7]
    assert (label == (classes == 7)).all()


def test_supporters_are_those_labelled_and_unknown_where_one_is_hidden(whole: Path) -> None:
    _, truth = NYUv2(whole).read("nyu_0003")
    known = {o.id: (o.supported_by, o.support_types) for o in truth.objects}
    assert known == {
        1: ((3,), ("below",)),
        3: ((2, 4), ("below", "behind")),
        5: (None, None),
        6: ((3,), ("below",)),
    }
    assert truth.support_annotated


def test_support_labels_of_more_regions_than_there_are_are_refused(root: Path) -> None:
    write_supports(root / SUPPORTS, farthest=7)
    with pytest.raises(FrameError, match=r"support_labels\.mat: must speak of the 6 regions .* region 7"):
        NYUv2(root).read("nyu_0001")


def test_without_support_labels_no_supports_are_claimed(root: Path) -> None:
    (root / SUPPORTS).unlink()
    _, truth = NYUv2(root).read("nyu_0001")
    assert not truth.support_annotated
    assert all(o.supported_by is None for o in truth.objects)


def test_the_official_split_is_that_of_its_file_and_none_without(root: Path) -> None:
    data = NYUv2(root)
    assert data.scenes() == ["nyu_0001", "nyu_0002", "nyu_0003"]
    assert data.official() == {"train": ["nyu_0001", "nyu_0003"], "test": ["nyu_0002"]}
    (root / SPLIT).unlink()
    assert data.official() == {}


@pytest.mark.parametrize(
    "scene", ["nyu_0004", "nyu_0000", "nyu_1", "nyu_-001", "elsewhere", "nyu_\u0660\u0660\u0660\u0661"]
)
def test_an_image_that_is_not_there_is_one_line(whole: Path, scene: str) -> None:
    with pytest.raises(FrameError):
        NYUv2(whole).read(scene)


def test_a_truncated_file_is_one_line_that_names_it(root: Path) -> None:
    content = (root / LABELLED).read_bytes()
    (root / LABELLED).write_bytes(content[: len(content) // 2])
    with pytest.raises(FrameError, match=rf"^{root / LABELLED}: .*copy the file again\.$|copy it again\.$"):
        NYUv2(root).read("nyu_0001")


def test_a_stamp_changes_with_the_file_and_the_scene(root: Path) -> None:
    data = NYUv2(root)
    before = data.stamp("nyu_0001")
    assert before != data.stamp("nyu_0002")
    write_supports(root / SUPPORTS, farthest=5)
    assert NYUv2(root).stamp("nyu_0001") != before
