"""Boxes from files: what anybody's detector writes, and what is refused in one line."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import pytest
import torch

from blockstab.output.export import scene_record
from blockstab.rgbd.reading import FrameError
from blockstab.stability.arrangement import MOST_BOXES, Arrangement, read_arrangement
from tests.table_scene import parsed_table

CUBE = {"center": [0.0, 0.05, 0.0], "size": [0.1, 0.1, 0.1]}
HALF = math.sqrt(0.5)


def read(tmp_path: Path, content: Any) -> Arrangement:
    (tmp_path / "boxes.json").write_text(json.dumps(content))
    return read_arrangement(tmp_path / "boxes.json")


def test_a_list_of_boxes_stands_on_its_lowest_corner(tmp_path: Path) -> None:
    found = read(tmp_path, [{**CUBE, "id": "a"}, {"center": [1, 0.3, 0], "half_extent": [0.1, 0.2, 0.3]}])
    assert found.ids == ("a", "1")
    assert found.boxes.half_extent.tolist() == [[0.05, 0.05, 0.05], [0.1, 0.2, 0.3]]
    assert found.ground_height == pytest.approx(0.0)
    assert found.movable.tolist() == [True, True]


def test_a_quaternion_and_a_matrix_turn_alike(tmp_path: Path) -> None:
    quarter = [[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]
    found = read(
        tmp_path, [{**CUBE, "rotation": quarter}, {**CUBE, "quaternion": [2 * HALF, 0, 0, 2 * HALF]}]
    )
    torch.testing.assert_close(found.boxes.rotation[0], found.boxes.rotation[1])


def test_up_may_be_any_direction_and_the_ground_at_any_height(tmp_path: Path) -> None:
    up = {"boxes": [{"center": [0, 0, 2.0], "size": [0.1, 0.2, 0.3], "background": True}], "up": [0, 0, 5]}
    found = read(tmp_path, up)
    assert float(found.boxes.center[0, 1]) == pytest.approx(2.0)
    assert found.ground_height == pytest.approx(1.85)
    assert found.movable.tolist() == [False]
    assert read(tmp_path, {**up, "ground_m": -1}).ground_height == -1.0


def test_a_scene_of_ours_has_the_same_boxes_in_the_world(tmp_path: Path) -> None:
    parsed = parsed_table()
    found = read(tmp_path, scene_record(parsed))
    assert found.ids == tuple(map(str, parsed.ids))
    torch.testing.assert_close(found.boxes.center, parsed.scene.boxes.center)
    assert found.movable.tolist() == (~parsed.scene.background).tolist()
    assert found.ground_height == pytest.approx(parsed.scene.ground.height)
    assert bool((found.slack > 0).all())


@pytest.mark.parametrize(
    ("content", "message"),
    [
        ([], "must hold a list of boxes"),
        ("cube", "must hold a list of boxes"),
        ([{**CUBE, "center": [0, 0]}], "center of box 0 must be 3 finite numbers"),
        ([{**CUBE, "size": None}], "size of box 0 must be 3 finite numbers"),
        ([CUBE, {"center": [0, 0, 0]}], "half_extent of box 1 must be 3 finite numbers"),
        ([{**CUBE, "rotation": [[1, 0, 0]]}], "rotation of box 0 must be three rows"),
        ([{**CUBE, "rotation": [[1, 0, 0], [0, 1, 0], [0, 0, 2]]}], "orthonormal"),
        ([{**CUBE, "quaternion": [0, 0, 0, 0]}], "quaternion of box 0 must be four numbers"),
        ([{**CUBE, "size": [0.1, 0.0, 0.1]}], "Half extents must be at least"),
        ([{**CUBE, "id": 1}, {**CUBE, "id": "1"}], "each box needs an id of its own"),
        ([CUBE] * (MOST_BOXES + 1), "at most 500 boxes, but holds 501"),
        ({"boxes": [CUBE], "up": [0, 0, 0]}, "up must be three finite numbers"),
        ({"boxes": [CUBE], "ground_m": "low"}, "ground_m must be a finite number"),
        ({"segments": [{"id": 1}]}, "must have up_camera"),
    ],
)
def test_what_is_no_arrangement_is_refused_in_one_line(tmp_path: Path, content: Any, message: str) -> None:
    with pytest.raises(FrameError, match=message) as caught:
        read(tmp_path, content)
    assert str(caught.value).startswith(str(tmp_path / "boxes.json"))
    assert "\n" not in str(caught.value)
