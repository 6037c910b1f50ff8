"""`blockstab export` writes every format, or one line and nothing."""

from __future__ import annotations

import json
from xml.etree import ElementTree

import pytest
from typer.testing import CliRunner

from blockstab.cli import app
from blockstab.commands.export import FORMATS

BOXES = [
    {"id": "table", "center": [0, 0.5, 0], "size": [1, 1, 1]},
    {"id": "cup", "center": [0, 1.05, 0], "size": [0.1, 0.1, 0.1]},
]


@pytest.fixture
def boxes(tmp_path):
    path = tmp_path / "boxes.json"
    path.write_text(json.dumps(BOXES))
    return path


def test_every_format_is_written_in_one_go(boxes, tmp_path):
    files = [tmp_path / "out" / f"world{ending}" for ending in FORMATS]
    result = CliRunner().invoke(app, ["export", str(boxes), *map(str, files)])
    assert result.exit_code == 0, result.output
    assert all(file.stat().st_size > 0 for file in files)
    names = [body.get("name") for body in ElementTree.parse(files[0]).getroot().iter("body")]
    assert names == ["table", "cup"]


def test_an_unknown_ending_is_one_line_and_nothing_is_written(boxes, tmp_path):
    good, bad = tmp_path / "world.glb", tmp_path / "world.fbx"
    result = CliRunner().invoke(app, ["export", str(boxes), str(good), str(bad)])
    assert result.exit_code == 1
    assert ".xml, .urdf, .glb, .ply" in result.output
    assert not good.exists()
