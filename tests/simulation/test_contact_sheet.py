"""One image of all scenes."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from blockstab.rgbd.reading import FrameError
from blockstab.simulation.contact_sheet import MOST, contact_sheet


def write_one(folder: Path, color: tuple[int, int, int]) -> Path:
    """A scene of one colour, with an object in its middle."""
    folder.mkdir(parents=True)
    Image.new("RGB", (64, 48), color).save(folder / "color.png")
    depth, label = np.full((48, 64), 1000, np.uint16), np.ones((48, 64), np.uint16)
    label[10:30, 20:40] = 2
    Image.fromarray(depth).save(folder / "depth.png")
    Image.fromarray(label).save(folder / "label.png")
    meta = {"fx": 50, "fy": 50, "cx": 32, "cy": 24, "depth_unit": "mm", "background_ids": [1]}
    (folder / "meta.json").write_text(json.dumps(meta))
    return folder


def share(sheet: Path, color: tuple[int, int, int]) -> float:
    return float((np.asarray(Image.open(sheet)) == color).all(axis=-1).mean())


@pytest.mark.parametrize("count", [1, 3, 10])
def test_every_scene_is_on_the_sheet(tmp_path: Path, count: int) -> None:
    colors = [(10 + 20 * i, 99, 200 - 10 * i) for i in range(count)]
    folders = [write_one(tmp_path / f"scene_{i}", color) for i, color in enumerate(colors)]
    contact_sheet(folders, tmp_path / "sheet.png")
    shares = [share(tmp_path / "sheet.png", color) for color in colors]
    assert min(shares) > 0.5 * 0.5 / (count + 6)
    assert max(shares) - min(shares) < 1e-4


def test_of_many_scenes_an_even_choice_is_shown(tmp_path: Path) -> None:
    folder = write_one(tmp_path / "one", (250, 0, 0))
    last = write_one(tmp_path / "two", (0, 0, 250))
    contact_sheet([folder] * 100 + [last] * 100, tmp_path / "sheet.png")
    one, two = (share(tmp_path / "sheet.png", color) for color in ((250, 0, 0), (0, 0, 250)))
    assert one == pytest.approx(two)
    assert MOST == 64


def test_the_sheet_replaces_an_older_one_and_leaves_nothing_beside_it(tmp_path: Path) -> None:
    folder = write_one(tmp_path / "set" / "one", (250, 0, 0))
    out = tmp_path / "out" / "sheet.png"
    out.parent.mkdir()
    out.write_bytes(b"old")
    contact_sheet([folder], out)
    assert [path.name for path in out.parent.iterdir()] == ["sheet.png"]
    assert Image.open(out).format == "PNG"


def test_without_scenes_or_with_a_broken_one_there_is_no_sheet(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="one scene folder or more"):
        contact_sheet([], tmp_path / "sheet.png")
    with pytest.raises(FrameError, match="meta"):
        contact_sheet([tmp_path], tmp_path / "sheet.png")
    assert not list(tmp_path.iterdir())
