"""The page that a person reads."""

from __future__ import annotations

from dataclasses import replace
from html.parser import HTMLParser

import pytest
import torch

from blockstab.output.report import report_html
from blockstab.parsing.parsed import Parsed
from tests.table_scene import parsed_table, with_scene


class Page(HTMLParser):
    """The tags, the visible text and the table rows of a page."""

    def __init__(self, html: str) -> None:
        super().__init__()
        self.tags: list[tuple[str, dict[str, str | None]]] = []
        self.text = ""
        self.rows: list[list[str]] = []
        self.feed(html)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append((tag, dict(attrs)))
        if tag == "tr":
            self.rows.append([])
        if tag in ("td", "th"):
            self.rows[-1].append("")

    def handle_data(self, data: str) -> None:
        inside = self.tags[-1][0] if self.tags else ""
        if inside not in ("script", "style"):
            self.text += data
        if self.rows and self.rows[-1] and not data.isspace():
            self.rows[-1][-1] += data


@pytest.fixture
def parsed() -> Parsed:
    return parsed_table()


def test_a_page_asks_for_nothing_outside_itself(parsed: Parsed) -> None:
    tags = Page(report_html(parsed)).tags
    assert not [
        tag for tag, attributes in tags if tag == "link" or "src" in attributes or "href" in attributes
    ]
    assert sum(tag == "script" for tag, _ in tags) == 7  # plotly.js, five figures and what a click shows


def test_a_page_names_its_scene_and_sums_it_up(parsed: Parsed) -> None:
    text = Page(report_html(replace(parsed, name="shelf 3"))).text
    assert text.count("shelf 3") == 2  # title and heading
    assert "3 objects · 1 unstable · energy 2.500 · 1.8 s · up known with confidence 0.90" in text
    assert "unsure" not in text


def test_a_name_is_text_and_never_markup(parsed: Parsed) -> None:
    html = report_html(replace(parsed, name="<script>alert(1)</script>", potentials_name="<b>svm</b>"))
    assert "<script>alert" not in html
    assert "<b>svm" not in html
    assert "&lt;script&gt;alert(1)&lt;/script&gt;" in html


def test_a_page_warns_of_an_unsure_up_direction_and_of_a_missing_ground(parsed: Parsed) -> None:
    ground = replace(parsed.scene.ground, confidence=0.3, height=None)
    text = Page(report_html(with_scene(parsed, ground=ground))).text
    assert "The up direction is unsure" in text
    assert "No ground plane was found" in text


def test_the_table_lists_objects_then_background(parsed: Parsed) -> None:
    rows = Page(report_html(parsed)).rows
    assert [row[0] for row in rows] == ["id", "2", "40", "5", "7"]
    assert rows[1][2:] == ["20.0 x 20.0 x 20.0", "stable", "40.0", "0.10", "7 (surface)", "40, 5", "3"]
    assert rows[2][3:7] == ["unstable", "-12.0", "0.80", "2 (partial)"]
    assert rows[3][4:7] == ["", "0.30", "ground (surface), 2 (side)"]
    assert rows[4][3:5] == ["background", ""]


def test_a_scene_of_background_alone_has_a_page(parsed: Parsed) -> None:
    everything = with_scene(parsed, background=torch.ones(4, dtype=torch.bool))
    assert "0 objects" in Page(report_html(everything)).text
