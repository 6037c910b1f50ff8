"""scene.json and labels.png: what a program reads."""

from __future__ import annotations

import copy
import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import jsonschema
import numpy as np
import pytest
import torch
from PIL import Image

from blockstab.boxes.box import Boxes
from blockstab.output.export import scene_record, scene_schema, write_parsed, write_whole
from blockstab.parsing.parsed import Parsed
from tests.table_scene import IDS, parsed_table, with_scene
from tests.tolerance import EXACT


@pytest.fixture
def parsed() -> Parsed:
    return parsed_table()


def test_a_record_follows_the_schema(parsed: Parsed) -> None:
    jsonschema.Draft202012Validator.check_schema(scene_schema())
    jsonschema.validate(scene_record(parsed), scene_schema())


@pytest.mark.parametrize(
    ("path", "value"),
    [
        (["schema"], 1),
        (["surprise"], 1),
        (["up_camera"], [0.0, 1.0]),
        (["up_confidence"], 1.2),
        (["ground_height_m"], "low"),
        (["segments", 0, "margin_m"], 0.1),  # background has none
        (["segments", 1, "id"], 0),
        (["segments", 1, "box", "half_extent"], [0.1, 0.0, 0.1]),
        (["segments", 1, "box", "corners"], []),
        (["segments", 1, "badness"], -0.1),
        (["pairs", 1, "potential"], 0.5),  # others have none
        (["supports", 0, "type"], "top"),
        (["supports", 0, "supported"], 0),
        (["falls_if_removed", "0"], []),
        (["potentials", "sha256"], "unknown"),
    ],
)
def test_the_schema_rejects(parsed: Parsed, path: list[Any], value: object) -> None:
    record = copy.deepcopy(scene_record(parsed))
    target: Any = record
    for key in path[:-1]:
        target = target[key]
    target[path[-1]] = value
    with pytest.raises(jsonschema.ValidationError):
        jsonschema.validate(record, scene_schema())


def test_the_schema_misses_every_key_that_is_taken_away(parsed: Parsed) -> None:
    record = scene_record(parsed)
    for key in record:
        with pytest.raises(jsonschema.ValidationError):
            jsonschema.validate({k: v for k, v in record.items() if k != key}, scene_schema())


def test_supports_name_output_ids_and_zero_is_the_ground(parsed: Parsed) -> None:
    found = [(s["supporter"], s["supported"], s["type"]) for s in scene_record(parsed)["supports"]]
    assert found == [(7, 2, "surface"), (2, 40, "partial"), (0, 5, "surface"), (2, 5, "side")]


def test_falls_name_output_ids_in_order(parsed: Parsed) -> None:
    assert scene_record(parsed)["falls_if_removed"] == {"2": [5, 40], "40": [], "5": []}


def test_only_neighbours_have_a_potential_and_in_their_order(parsed: Parsed) -> None:
    pairs = {(p["a"], p["b"]): p["potential"] for p in scene_record(parsed)["pairs"]}
    potentials = {key: value for key, value in pairs.items() if value is not None}
    assert len(pairs) == 6
    assert potentials == {(7, 2): pytest.approx(0.3), (2, 40): pytest.approx(0.7)}


def test_a_margin_without_meaning_is_null(parsed: Parsed) -> None:
    margins = {s["id"]: s["margin_m"] for s in scene_record(parsed)["segments"]}
    assert margins == {7: None, 2: 0.04, 40: -0.012, 5: None}


def test_boxes_and_directions_return_to_the_world_by_the_recorded_rotation(parsed: Parsed) -> None:
    record = json.loads(json.dumps(scene_record(parsed)))
    turn = torch.tensor(record["world_from_camera"], dtype=torch.float64)
    found = [
        torch.tensor([s["box"][key] for s in record["segments"]], dtype=torch.float64)
        for key in ("center", "rotation", "half_extent")
    ]
    world, truth = Boxes(*found).rotated(turn), parsed.scene.boxes
    torch.testing.assert_close(world.corners(), truth.corners(), atol=EXACT, rtol=0)
    direction = torch.tensor([p["direction_camera"] for p in record["pairs"]], dtype=torch.float64) @ turn.T
    torch.testing.assert_close(direction, parsed.scene.pairs.direction, atol=EXACT, rtol=0)


def test_recorded_boxes_lie_before_the_camera(parsed: Parsed) -> None:
    assert all(s["box"]["center"][2] > 0 for s in scene_record(parsed)["segments"])


def test_the_confidence_of_the_up_direction_is_recorded(parsed: Parsed) -> None:
    assert scene_record(parsed)["up_confidence"] == 0.9


def test_a_scene_without_ground_plane_has_no_ground_height(parsed: Parsed) -> None:
    record = scene_record(with_scene(parsed, ground=replace(parsed.scene.ground, height=None)))
    assert record["ground_height_m"] is None
    jsonschema.validate(record, scene_schema())


def test_a_number_that_is_not_finite_is_named(parsed: Parsed) -> None:
    broken = replace(parsed, unary=torch.tensor([0.1, float("nan"), 0.9, 0.4]))
    with pytest.raises(ValueError, match=r"table\.segments\[1\]\.potential .* nan"):
        scene_record(broken)


def test_the_same_parse_gives_the_same_bytes(tmp_path: Path) -> None:
    for folder in ("one", "two"):
        write_parsed(parsed_table(), tmp_path / folder)
    names = sorted(path.name for path in (tmp_path / "one").iterdir())
    assert names == ["labels.png", "report.html", "scene.json"]
    for name in names:
        assert (tmp_path / "one" / name).read_bytes() == (tmp_path / "two" / name).read_bytes()


def test_labels_are_kept_in_sixteen_bits(parsed: Parsed, tmp_path: Path) -> None:
    ids = (65535, *IDS[1:])
    label = torch.where(parsed.label == IDS[0], 65535, parsed.label)
    write_parsed(replace(parsed, ids=ids, label=label), tmp_path)
    assert np.array_equal(np.array(Image.open(tmp_path / "labels.png")), label.numpy())


def test_an_id_beyond_sixteen_bits_is_refused_and_nothing_written(parsed: Parsed, tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="65536"):
        write_parsed(replace(parsed, ids=(65536, *IDS[1:])), tmp_path / "out")
    assert not (tmp_path / "out").exists()


def test_a_killed_write_leaves_the_old_file_whole(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "file"
    write_whole(path, b"old")
    monkeypatch.setattr(Path, "replace", _killed)
    with pytest.raises(KeyboardInterrupt):
        write_whole(path, b"new")
    assert [p.read_bytes() for p in tmp_path.iterdir()] == [b"old"]


def test_a_killed_write_leaves_no_folder_that_looks_finished(
    parsed: Parsed, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    write_parsed(parsed, tmp_path)
    monkeypatch.setattr(Path, "replace", _killed)
    with pytest.raises(KeyboardInterrupt):
        write_parsed(parsed, tmp_path)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["labels.png", "report.html"]


def _killed(*_: object) -> None:
    raise KeyboardInterrupt
