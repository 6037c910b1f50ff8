"""The scripts that draw what searches do."""

from __future__ import annotations

import sys
from importlib import import_module
from types import ModuleType
from xml.etree import ElementTree

import pytest
from PIL import Image

from blockstab.features.columns import COLUMNS
from blockstab.testing.photographs import BLOCKS, photograph
from models.potentials.checkpoint import save_potentials
from tests.docs.pages import DOCS
from tests.synthetic import write_folder
from tests.toy_potentials import toy_potentials

SVG = "{http://www.w3.org/2000/svg}"


@pytest.fixture
def script(monkeypatch):
    """Import a script as it finds its neighbours when it is run."""
    monkeypatch.syspath_prepend(str(DOCS / "figures"))
    before = set(sys.modules)
    yield import_module
    for name in set(sys.modules) - before:
        if str(DOCS) in str(getattr(sys.modules[name], "__file__", "")):
            del sys.modules[name]


def results(**course: dict[str, list[float]]) -> dict:
    row = {
        "method": "R-Samp",
        "scores": {"overlap": 0.8, "rank_correlation": -0.714},
        "course": course,
    }
    return {"data": {"name": "osd", "images": 8}, "rows": [row]}


def curve(*mean: float) -> dict[str, list[float]]:
    return {"mean": list(mean), "low": [v - 0.01 for v in mean], "high": [v + 0.01 for v in mean]}


def test_curves_go_from_side_to_side_and_up_where_values_rise(script):
    energy: ModuleType = script("energy")
    drawn = energy.drawing([results(energy=curve(0.3, 0.2, 0.1), overlap=curve(0.5, 0.6, 0.9))], "R-Samp")
    tree = ElementTree.fromstring(drawn)
    texts = [text.text for text in tree.iter(f"{SVG}text")]
    assert "rank correlation -0.71, 8 images" in texts
    score, falling = (
        [tuple(map(float, point.split(","))) for point in line.get("points", "").split()]
        for line in tree.iter(f"{SVG}polyline")
    )
    assert [x for x, _ in score] == [energy.MARGIN + energy.WIDTH * k / 2 for k in range(3)]
    assert score[0][1] > score[1][1] > score[2][1]
    assert falling[0][1] < falling[1][1] < falling[2][1]


def test_results_without_a_course_are_refused(script):
    with pytest.raises(ValueError, match="run experiment=figure13"):
        script("energy").drawing([{**results(), "rows": []}], "R-Samp")


@pytest.mark.parametrize(("name", "panels"), [("potentials", 4), ("sequence", 3)])
def test_a_search_is_drawn_in_a_row_of_panels(script, tmp_path, monkeypatch, name, panels):
    toy = toy_potentials()
    save_potentials(tmp_path / "toy", {k: getattr(toy, k) for k in COLUMNS}, toy.weight, {})
    folder = write_folder(photograph(*BLOCKS).frame, tmp_path / "scene")
    module = script(name)
    monkeypatch.setattr(
        sys, "argv", [name, str(folder), "--potentials", f"{tmp_path}/toy.json", "--out", f"{tmp_path}/a.png"]
    )
    module.main()
    width = Image.open(tmp_path / "a.png").width
    assert width >= panels * module.WIDTH


def test_the_cost_of_a_step_is_a_curve_for_each_kind_and_one_in_proportion(script):
    step_cost = script("step_cost")
    rows = [
        {"cubes": name, "objects": count, "milliseconds": time}
        for name, time in (("apart", 20.0), ("near", 40.0))
        for count in (5, 80)
    ]
    picture = ElementTree.fromstring(step_cost.drawing(rows))
    curves = [line.attrib["points"].split() for line in picture.iter(f"{SVG}polyline")]
    heights = [[float(point.split(",")[1]) for point in curve] for curve in curves]
    assert len(curves) == 3
    assert heights[0][0] > heights[0][1]  # in proportion, which goes up
    assert heights[1][0] == heights[1][1] > heights[2][0] == heights[2][1]
    x, y = step_cost.place(20.0, 100.0)
    assert step_cost.LEFT < x < step_cost.LEFT + step_cost.WIDTH
    assert y == step_cost.TOP + step_cost.HEIGHT / 2
