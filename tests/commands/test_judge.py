"""Judges of anybody's boxes, from the command line."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner

from blockstab.cli import app
from blockstab.output.export import scene_record
from tests.table_scene import parsed_table

# A post, a beam that overhangs it, and a weight that holds the beam: `COUNTERWEIGHT` of the worlds.
BEAM = [
    {"id": "post", "center": [0, 0.1, 0], "size": [0.1, 0.2, 0.1]},
    {"id": "beam", "center": [0.12, 0.215, 0], "size": [0.4, 0.03, 0.1]},
    {"id": "weight", "center": [-0.04, 0.33, 0], "size": [0.08, 0.2, 0.1]},
]


def judged(tmp_path: Path, content: Any, *options: str) -> tuple[dict[str, Any], str]:
    (tmp_path / "boxes.json").write_text(json.dumps(content))
    words = ["judge", str(tmp_path / "boxes.json"), "--out", str(tmp_path / "judged.json"), *options]
    done = CliRunner().invoke(app, words)
    assert done.exit_code == 0, done.output
    return json.loads((tmp_path / "judged.json").read_text()), done.output


def test_judges_say_what_stands_what_falls_and_that_there_is_no_order(tmp_path: Path) -> None:
    said, shown = judged(tmp_path, BEAM)
    assert list(said["judges"]) == ["paper", "equilibrium"]
    for told in said["judges"].values():
        assert set(told["stable"].values()) == {True}
        assert told["falls_if_removed"] == {
            "post": ["beam", "weight"],
            "beam": ["weight"],
            "weight": ["beam"],
        }
        assert told["removal_order"] is None
    assert said["disputed"] == []
    assert 0 < said["least_tilt_deg"] < 45
    assert "The judges disagree about: nothing" in shown


def test_physics_sees_the_same_fall(tmp_path: Path) -> None:
    pytest.importorskip("mujoco", reason="the extra `sim` is not installed")
    said, _ = judged(tmp_path, BEAM, "--by", "equilibrium,physics")
    assert said["disputed"] == []
    assert "removal_order" not in said["judges"]["physics"]


def test_a_scene_of_ours_can_be_judged(tmp_path: Path) -> None:
    said, _ = judged(tmp_path, scene_record(parsed_table()), "--by", "paper")
    assert set(said["judges"]["paper"]["stable"]) == {"2", "40", "5"}


@pytest.mark.parametrize(
    ("content", "options", "message"),
    [
        (BEAM, ["--by", "jury"], "no judge 'jury'; choose from: paper, equilibrium, physics"),
        ([{**BEAM[0], "background": True}], ["--by", "physics"], "some of these are background"),
        ([{"id": 1}], [], "center of box 0 must be 3 finite numbers"),
    ],
)
def test_what_cannot_be_judged_is_said_in_one_line_and_nothing_is_written(
    tmp_path: Path, content: Any, options: list[str], message: str
) -> None:
    (tmp_path / "boxes.json").write_text(json.dumps(content))
    words = ["judge", str(tmp_path / "boxes.json"), "--out", str(tmp_path / "judged.json"), *options]
    done = CliRunner().invoke(app, words)
    assert done.exit_code == 1
    assert message in done.output
    assert not (tmp_path / "judged.json").exists()
