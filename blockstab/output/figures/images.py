"""The flat figures of a report: the image with its segments, the depth, the energy."""

from __future__ import annotations

from base64 import b64encode
from io import BytesIO

import torch
from PIL import Image
from torch import Tensor

from blockstab.output.coloring import DEPTH_RAMP, depth_colored, depth_range, outlined
from blockstab.output.figures.figure import Figure, Trace
from blockstab.output.figures.marks import CALM, describe, image_middles, segment_colors
from blockstab.parsing.parsed import Parsed


def segments_figure(parsed: Parsed) -> Figure:
    """The colour image with the outline of every segment, and the ids of the objects."""
    palette = torch.zeros(max(int(parsed.label.max()), *parsed.ids, 0) + 1, 3, dtype=torch.uint8)
    for i, color in zip(parsed.ids, segment_colors(parsed.scene), strict=True):
        palette[i] = torch.tensor(list(bytes.fromhex(color[1:])), dtype=torch.uint8)
    objects = (~parsed.scene.background).nonzero().flatten().tolist()
    columns, rows = image_middles(parsed)[objects].T.tolist()
    ids = {
        "type": "scatter",
        "x": columns,
        "y": rows,
        "text": [f"<b>{parsed.ids[i]}</b>" for i in objects],
        "hovertext": [describe(parsed, i) for i in objects],
        "hoverinfo": "text",
        "mode": "markers+text",
        "marker": {"size": 19, "color": "black", "opacity": 0.6},
        "textfont": {"color": "white", "size": 11},
    }
    return _picture(outlined(parsed.frame.color, parsed.label, palette), "JPEG", 0, ids)


def depth_figure(parsed: Parsed) -> Figure:
    """The depth image, with its scale in metres."""
    near, far = depth_range(parsed.frame.depth)
    steps = len(DEPTH_RAMP) - 1
    marker = {
        "color": [near],
        "cmin": near,
        "cmax": far,
        "colorscale": [[k / steps, f"rgb{rgb}"] for k, rgb in enumerate(DEPTH_RAMP)],
        "colorbar": {"title": {"text": "m"}, "thickness": 10, "tickformat": ".2f", "len": 1.05, "x": 1.0},
    }
    # A picture can have no colour bar: a trace without points carries it.
    bar = {"type": "scatter", "x": [None], "y": [None], "mode": "markers", "marker": marker}
    return _picture(depth_colored(parsed.frame.depth, near, far), "PNG", 58, bar)


def energy_figure(parsed: Parsed) -> Figure:
    """The lowest energy known after each round of the search."""
    line = {
        "type": "scatter",
        "y": list(parsed.trace),
        "mode": "lines+markers",
        "line": {"color": CALM[0], "shape": "hv"},
    }
    return Figure(
        [line],
        xaxis={
            "title": {"text": "round"},
            "range": [-0.5, max(len(parsed.trace), 2) - 0.5],
            "tickformat": "d",
        },
        yaxis={"title": {"text": "energy"}},
        height=360,
        margin={"l": 60, "r": 10, "t": 10, "b": 45},
    )


def _picture(rgb: Tensor, file_format: str, right_px: int, over: Trace) -> Figure:
    """A picture with a trace over it, and some room to its right."""
    buffer = BytesIO()
    Image.fromarray(rgb.cpu().numpy()).save(buffer, format=file_format, quality=90)
    source = f"data:image/{file_format.lower()};base64,{b64encode(buffer.getvalue()).decode()}"
    height, width = rgb.shape[:2]
    return Figure(
        [{"type": "image", "source": source, "hoverinfo": "skip"}, over],
        xaxis={"visible": False, "range": [-0.5, width - 0.5], "constrain": "domain"},
        yaxis={"visible": False, "range": [height - 0.5, -0.5], "constrain": "domain"},
        height=315,
        margin={"l": 0, "r": right_px, "t": 0, "b": 0},
        showlegend=False,
    )
