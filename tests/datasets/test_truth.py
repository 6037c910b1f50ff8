"""Malformed truth is refused in one line that names the file and the culprit."""

from __future__ import annotations

import json
import time
from pathlib import Path
from typing import Any

import pytest

from blockstab.datasets.folder import read_truth
from blockstab.datasets.truth import parsed_truth

SHEARED = [[1, 0.2, 0, 0], [0, 1, 0, 0], [0, 0, 1, 1], [0, 0, 0, 1]]


@pytest.mark.parametrize(
    ("meta", "message"),
    [
        ([], "must be a JSON object, but it is"),
        ({"objects": {"id": 2}}, "objects must be a list"),
        ({"objects": [{"kind": "box"}]}, "entry 0 of objects has no id"),
        ({"objects": [{"id": True}]}, "the id in entry 0 of objects must be label ids"),
        ({"objects": [{"id": 70000}]}, "whole numbers from 1 to 65535"),
        ({"objects": [{"id": 2}, {"id": 2}]}, "id 2 is given to two objects"),
        ({"background_ids": [2], "objects": [{"id": 2}]}, "id 2 is given to"),
        ({"background_ids": 1}, "background_ids must be label ids"),
        ({"objects": [{"id": 2, "kind": 3}]}, "kind of object 2 must be a word"),
        ({"objects": [{"id": 2, "half_extent": [1, 2]}]}, "half_extent of object 2"),
        ({"objects": [{"id": 2, "half_extent": [1, 2, "x"]}]}, "half_extent of object 2"),
        ({"objects": [{"id": 2, "half_extent": [1, 2, 0]}]}, "half_extent of object 2 must be positive"),
        ({"objects": [{"id": 2, "half_extent": [1, 2, float("nan")]}]}, "must be finite"),
        ({"objects": [{"id": 2, "half_extent": [1, 2, 10**400]}]}, "must be finite"),
        ({"objects": [{"id": 2, "half_extent": ["x" * 10**5]}]}, "half_extent of object 2"),
        ({"objects": [{"id": 2, "kind": ["x"] * 10**5}]}, "kind of object 2 must be a word"),
        ({"objects": [{"id": 2, "pose_camera": [[1, 0], [0, 1]]}]}, "pose_camera of object 2"),
        ({"objects": [{"id": 2, "pose_camera": SHEARED}]}, "pose_camera of object 2 must be a rotation"),
        ({"objects": [{"id": 2, "supported_by": [5]}]}, "object 2 refers to id 5"),
        ({"objects": [{"id": 2, "falls_if_removed": [2]}]}, "object 2 refers to id 2"),
        ({"objects": [{"id": 2, "category": 7}]}, "category of object 2 must be a word"),
        ({"objects": [{"id": 2, "total_pixels": -1}]}, "total_pixels of object 2 must be a whole number"),
        ({"objects": [{"id": 2, "support_types": ["surface"]}]}, "support_types of object 2 must be one of"),
        (
            {"background_ids": [1], "objects": [{"id": 2, "supported_by": [1], "support_types": ["glued"]}]},
            "for each supporter, but is",
        ),
        ({"up_camera": [0, 1]}, "up_camera must be finite numbers"),
        ({"support_annotated": "yes"}, "support_annotated must be true or false"),
    ],
)
def test_malformed_truth_is_refused_in_one_line(tmp_path: Path, meta: Any, message: str) -> None:
    (tmp_path / "meta.json").write_text(json.dumps(meta))
    with pytest.raises(ValueError, match=message) as caught:
        read_truth(tmp_path)
    assert str(caught.value).startswith(f"{tmp_path / 'meta.json'}: ")
    assert "\n" not in str(caught.value)
    assert len(str(caught.value)) < len(str(tmp_path)) + 200


def test_as_many_objects_as_there_are_ids_are_checked_in_seconds() -> None:
    objects = [{"id": i, "supported_by": [i - 1]} for i in range(2, 65536)]
    start = time.process_time()
    assert len(parsed_truth({"background_ids": [1], "objects": objects}).objects) == 65534
    assert time.process_time() - start < 2


def test_a_file_that_is_no_json_is_named(tmp_path: Path) -> None:
    (tmp_path / "meta.json").write_text("{")
    with pytest.raises(ValueError, match=r"meta\.json: must be JSON"):
        read_truth(tmp_path)


def test_a_meta_file_that_says_nothing_of_objects_has_no_truth() -> None:
    truth = parsed_truth({"fx": 525.0})
    assert truth == type(truth)((), (), None, False)


def test_supports_count_as_annotated_where_every_object_gives_its_own() -> None:
    complete = [{"id": 2, "supported_by": [1]}, {"id": 3, "supported_by": [2]}]
    assert parsed_truth({"background_ids": [1], "objects": complete}).support_annotated
    partial = [{"id": 2, "supported_by": [1]}, {"id": 3}]
    assert not parsed_truth({"background_ids": [1], "objects": partial}).support_annotated
