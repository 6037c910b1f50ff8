"""The support graph."""

from __future__ import annotations

import re
from typing import Any

import pytest

from blockstab.output.figures.supports import support_figure
from blockstab.parsing.parsed import Parsed
from tests.output.figures.drawn import checked
from tests.table_scene import BLOCK, IDS, TOPPLING, parsed_table
from tests.tolerance import EXACT


@pytest.fixture
def parsed() -> Parsed:
    return parsed_table()


def test_supports_are_black_red_and_blue_by_their_kind(parsed: Parsed) -> None:
    traces = {t.name: t for t in checked(support_figure)(parsed).data}
    assert {n: t.line.color for n, t in traces.items() if t.line.color} == {
        "surface (2)": "black",
        "partial (1)": "red",
        "side (1)": "blue",
    }


def test_an_arrow_leads_from_supporter_to_supported(parsed: Parsed) -> None:
    figure = checked(support_figure)(parsed)
    nodes, arrow = _named(figure, "segments"), _named(figure, "partial")
    place = {
        int(re.sub(r"\D", "", text)): (x, y) for text, x, y in zip(nodes.text, nodes.x, nodes.y, strict=True)
    }
    ends = list(zip(arrow.x, arrow.y, strict=True))
    assert ends[0] == place[IDS[BLOCK]]
    assert ends[1] == place[IDS[TOPPLING]]
    assert arrow.marker.size[1] > arrow.marker.size[0] == 0


def test_nodes_stand_at_their_height_and_the_ground_is_a_green_dashed_circle_below(parsed: Parsed) -> None:
    figure = checked(support_figure)(parsed)
    nodes, circle = _named(figure, "segments"), figure.layout.shapes[0]
    assert list(nodes.y) == pytest.approx((parsed.scene.boxes.center[:, 1] + 0.6).tolist(), abs=EXACT)
    assert circle.type == "circle"
    assert circle.line.dash == "dash"
    assert circle.yanchor < min(nodes.y)


def _named(figure: Any, name: str) -> Any:
    return next(trace for trace in figure.data if trace.name.startswith(name))
