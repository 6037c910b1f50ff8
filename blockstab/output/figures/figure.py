"""Figures as plotly.js reads them, put into a page."""

from __future__ import annotations

from base64 import b64encode
from typing import Any

import numpy as np

Trace = dict[str, Any]

_FONT = {"size": 12, "color": "#333"}
_GRID = {"gridcolor": "#ebf0f8", "linecolor": "#ebf0f8", "zerolinecolor": "#ebf0f8", "zerolinewidth": 2}
_SPACE_AXIS = {
    **_GRID,
    "gridcolor": "#dfe8f3",
    "gridwidth": 2,
    "backgroundcolor": "white",
    "showbackground": True,
}
# What holds for all figures of a page; each overrides what it likes.
_TEMPLATE = {
    "layout": {
        "font": _FONT,
        "colorway": ["#636efa"],
        "hovermode": "closest",
        "hoverlabel": {"align": "left"},
        "xaxis": {**_GRID, "ticks": "", "automargin": True},
        "yaxis": {**_GRID, "ticks": "", "automargin": True},
        "scene": {f"{name}axis": {**_SPACE_AXIS, "ticks": ""} for name in "xyz"},
    }
}


class Figure(dict[str, Any]):
    """A figure: `data`, its traces, and `layout`, as plotly.js takes them.

    Plain values alone: plotly's own classes check each of ten thousand colours, which takes longer than to draw them.
    """

    def __init__(self, data: list[Trace], **layout: Any) -> None:
        super().__init__(data=data, layout=layout)


def division(figure: Figure, key: str, turned: bool) -> str:
    """The HTML of a figure, for a page that holds plotly.js.

    Args:
        key: names it within the page.
        turned: it is turned by hand, so the wheel zooms.
    """
    from plotly.io.json import to_json_plotly

    layout = {**figure["layout"], "template": _TEMPLATE}
    config = {"displayModeBar": False, "responsive": True, "scrollZoom": turned}
    traces = [{name: _packed(value) for name, value in trace.items()} for trace in figure["data"]]
    arguments = ", ".join(to_json_plotly(part) for part in (traces, layout, config))
    return f'<div id="figure-{key}"></div><script>Plotly.newPlot("figure-{key}", {arguments})</script>'


def _packed(value: Any) -> Any:
    """An array as bytes, which plotly.js takes for one: half as long as its digits."""
    if not isinstance(value, np.ndarray):
        return value
    packed = value.astype("<f4").tobytes()
    return {"dtype": "f4", "bdata": b64encode(packed).decode()}
