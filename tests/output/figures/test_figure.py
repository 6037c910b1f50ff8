"""Figures in a page."""

from __future__ import annotations

import json
import re
from base64 import b64decode

import numpy as np

from blockstab.output.figures.figure import Figure, division


def test_a_division_asks_plotly_for_the_traces_and_the_layout_of_its_figure() -> None:
    trace = {"type": "scatter", "x": [1, None], "y": np.array([0.5, np.nan])}
    html = division(Figure([trace], height=300), "energy", turned=False)
    found = re.fullmatch(
        r'<div id="figure-energy"></div><script>Plotly.newPlot\("figure-energy", (.*)\)</script>', html
    )
    assert found is not None
    data, layout, config = json.loads(f"[{found[1]}]")
    assert data[0]["x"] == [1, None]
    y = np.frombuffer(b64decode(data[0]["y"]["bdata"]), np.float32)
    assert data[0]["y"]["dtype"] == "f4"
    assert y[0] == 0.5
    assert np.isnan(y[1])
    assert layout["height"] == 300
    assert layout["template"]["layout"]["font"]["size"] == 12
    assert config["scrollZoom"] is False


def test_no_text_of_a_figure_ends_its_script() -> None:
    html = division(Figure([{"type": "scatter", "name": "</script><b>"}]), "boxes", turned=True)
    assert html.count("</script>") == 1
    assert "<b>" not in html
