"""The figure to turn by hand: the cloud and the boxes in it."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import torch
from torch import Tensor

from blockstab.boxes.box import Boxes
from blockstab.output.figures.figure import Figure, Trace
from blockstab.output.figures.marks import describe, segment_colors
from blockstab.parsing.parsed import Parsed
from blockstab.scene.completion import Verdict
from blockstab.stability.hidden_support import HiddenSupport

CLOUD_POINTS = 25_000  # more make a large file and a slow turn of the hand
FIELD_OF_VIEW_DEG = 45.0  # plotly's


def boxes_figure(parsed: Parsed) -> Figure:
    """The cloud in its colours and the objects' boxes, in the world frame, first seen from the camera's side.

    What lies far from the objects, such as the walls of a room, is left out.
    """
    objects = (~parsed.scene.background).nonzero().flatten()
    middle, radius = _sphere(parsed, objects)
    low, high = middle - 1.7 * radius, middle + 1.7 * radius
    axes = {
        f"{name}axis": {
            "range": [float(low[k]), float(high[k])],
            "title": {"text": f"{name}, m"},
            "nticks": 6,
        }
        for k, name in enumerate("xyz")
    }
    return Figure(
        [_cloud(parsed, low, high), *_wireframes(parsed, objects), _names(parsed, objects)],
        scene={**axes, "aspectmode": "cube", "camera": _camera(middle, radius), "dragmode": "orbit"},
        showlegend=False,
        height=672,
        margin={"l": 0, "r": 0, "t": 0, "b": 0},
    )


def _sphere(parsed: Parsed, objects: Tensor) -> tuple[Tensor, float]:
    """Centre (3,) and radius, metres, of a sphere around the objects' boxes, or else around all points."""
    points = parsed.scene.boxes.corners()[objects].flatten(0, 1)
    if not len(points):
        points = parsed.cloud.points[parsed.cloud.valid]
    if not len(points):
        points = torch.tensor([[-1.0, -1.0, -1.0], [1.0, 1.0, 1.0]], dtype=torch.float64)
    middle = (points.amin(dim=0) + points.amax(dim=0)) / 2
    return middle, float((points - middle).norm(dim=1).max())


def _camera(middle: Tensor, radius: float) -> dict[str, Any]:
    """Look at the objects from the camera's side and a little higher, from where they fill the view.

    Plotly places its eye in the cube of side 1 that the axes fill.
    """
    toward_camera = -middle / middle.norm().clamp(min=1e-9)
    toward_camera[1] += 0.12
    distance = 0.9 * radius / math.sin(math.radians(FIELD_OF_VIEW_DEG / 2))
    eye = toward_camera / toward_camera.norm() * distance / (3.4 * radius)
    return {
        "eye": dict(zip("xyz", eye.tolist(), strict=True)),
        "center": {"x": 0, "y": 0, "z": 0},
        "up": {"x": 0, "y": 1, "z": 0},
    }


def _cloud(parsed: Parsed, low: Tensor, high: Tensor) -> Trace:
    inside = parsed.cloud.valid & ((parsed.cloud.points > low) & (parsed.cloud.points < high)).all(dim=-1)
    step = max(1, math.ceil(math.sqrt(int(inside.sum()) / CLOUD_POINTS)))
    kept = inside[::step, ::step]
    points = parsed.cloud.points[::step, ::step][kept]
    color = parsed.frame.color[::step, ::step][kept].cpu().numpy()
    return {
        **_scattered(points),
        "mode": "markers",
        "marker": {"size": 4, "color": [f"#{r:02x}{g:02x}{b:02x}" for r, g, b in color.tolist()]},
        "hoverinfo": "skip",
        "name": "cloud",
    }


def _wireframes(parsed: Parsed, objects: Tensor) -> list[Trace]:
    """Boxes as they were seen, and, dashed, as they were completed; dotted, where something unseen may carry one."""
    colors = segment_colors(parsed.scene)
    seen, whole = _lines(parsed.seen), _lines(parsed.scene.boxes)
    traces = []
    for i in objects.tolist():
        style = {
            "mode": "lines",
            "line": {"color": colors[i], "width": 5},
            "hovertext": describe(parsed, i),
            "hoverinfo": "text",
            "customdata": [parsed.ids[i]] * len(whole[i]),
        }
        traces.append({**_scattered(seen[i]), **style, "name": f"box {parsed.ids[i]}"})
        if parsed.verdict[i] == Verdict.COMPLETED:
            dashed = {"color": colors[i], "width": 3, "dash": "dash"}
            traces.append({**_scattered(whole[i]), **style, "line": dashed, "name": f"whole {parsed.ids[i]}"})
        if i in parsed.unseen:
            dotted = {"color": colors[i], "width": 3, "dash": "dot"}
            around = _outline(parsed.unseen[i])
            traces.append({**_scattered(around), **style, "line": dotted, "name": f"unseen {parsed.ids[i]}"})
    return traces


def _lines(boxes: Boxes) -> Tensor:
    """(N, 36, 3) the edges of boxes, one after the other, the pen lifted in between."""
    pen_up = torch.full((len(boxes), 12, 1, 3), torch.nan, dtype=torch.float64)
    return torch.cat([boxes.edges(), pen_up], dim=2).flatten(1, 2)


def _outline(found: HiddenSupport) -> Tensor:
    """The outline of what was not seen, at its top and its foot, with the pen lifted in between."""
    ring = torch.cat([found.area, found.area[:1]])
    pen_up = torch.full((1, 3), torch.nan, dtype=torch.float64)
    levels = [
        torch.cat([ring[:, :1], torch.full((len(ring), 1), height, dtype=torch.float64), ring[:, 1:]], dim=1)
        for height in (found.top, found.bottom)
    ]
    return torch.cat([levels[0], pen_up, levels[1]])


def _names(parsed: Parsed, objects: Tensor) -> Trace:
    boxes, colors = parsed.scene.boxes, segment_colors(parsed.scene)
    tops = boxes.center[objects].clone()
    tops[:, 1] = boxes.corners()[objects][..., 1].amax(dim=1) + 0.01
    return {
        **_scattered(tops),
        "mode": "text",
        "text": [_name(parsed, i) for i in objects.tolist()],
        "textfont": {"color": [colors[i] for i in objects.tolist()], "size": 15},
        "hoverinfo": "skip",
        "name": "ids",
    }


def _name(parsed: Parsed, i: int) -> str:
    """The id, and behind it, small, when the thing can be taken away."""
    order = parsed.removal.order or ()
    return f"<b>{parsed.ids[i]}</b>" + (f"<sub> {order.index(i) + 1}.</sub>" if i in order else "")


def _scattered(points: Tensor) -> Trace:
    columns = points.T.cpu().numpy().astype(np.float32)
    return {"type": "scatter3d", **dict(zip("xyz", columns, strict=True))}
