"""The support graph, drawn as in the paper's Fig. 16."""

from __future__ import annotations

from typing import Any

from blockstab.output.figures.figure import Figure, Trace
from blockstab.output.figures.marks import GREEN, describe, image_middles, segment_colors
from blockstab.parsing.parsed import Parsed
from blockstab.stability.support import GROUND, SupportType

Place = tuple[float, float]

SUPPORT_COLORS = {SupportType.SURFACE: "black", SupportType.PARTIAL: "red", SupportType.SIDE: "blue"}
NODE_PX = 26


def support_figure(parsed: Parsed) -> Figure:
    """Ids at the height of their boxes, left to right as in the image; arrows from supporter to supported.

    Background takes part where it supports something. The ground plane is a green dashed circle below all.
    """
    scene, colors = parsed.scene, segment_colors(parsed.scene)
    places = _places(parsed)
    shown = sorted(set(places) - {GROUND})
    relations = list(
        zip(
            scene.supports.supporter.tolist(),
            scene.supports.supported.tolist(),
            scene.supports.type.tolist(),
            strict=True,
        )
    )
    arrows = [
        _arrows(kind, [(places[a], places[b]) for a, b, t in relations if t == kind]) for kind in SupportType
    ]
    nodes = {
        "type": "scatter",
        "x": [places[i][0] for i in shown],
        "y": [places[i][1] for i in shown],
        "text": [f"<b>{parsed.ids[i]}</b>" for i in shown],
        "hovertext": [describe(parsed, i) for i in shown],
        "hoverinfo": "text",
        "mode": "markers+text",
        "textfont": {"color": "white", "size": 12},
        "marker": {"size": NODE_PX, "opacity": 1, "color": [colors[i] for i in shown]},
        "showlegend": False,
        "name": "segments",
    }
    return Figure(
        [*arrows, nodes],
        shapes=[_ground(places[GROUND])],
        xaxis={"visible": False, "range": [-0.7, max(len(shown), 1) - 0.3]},
        yaxis={"title": {"text": "height of the box's centre, m"}, "zeroline": False},
        legend={"orientation": "h", "y": 1.14, "x": 0},
        height=360,
        margin={"l": 60, "r": 10, "t": 34, "b": 12},
    )


def _places(parsed: Parsed) -> dict[int, Place]:
    """Place of each shown segment index and of `GROUND`: rank across the image, metres above the ground."""
    scene = parsed.scene
    linked = {*scene.supports.supporter.tolist(), *scene.supports.supported.tolist()} - {GROUND}
    shown = sorted(linked | set((~scene.background).nonzero().flatten().tolist()))
    # Ranks, not pixels: two things of one height, one behind the other, would cover each other.
    ranks = image_middles(parsed)[shown, 0].argsort(stable=True).argsort().tolist()
    heights = (scene.boxes.center[shown, 1] - (scene.ground.height or 0.0)).tolist()
    low, high = min(heights, default=0.0), max(heights, default=0.0)
    ground = ((len(shown) - 1) / 2, low - 0.3 * max(high - low, 0.1))
    return {GROUND: ground, **dict(zip(shown, zip(ranks, heights, strict=True), strict=True))}


def _arrows(kind: SupportType, ends: list[tuple[Place, Place]]) -> Trace:
    """All arrows of one kind, as a broken line whose every second point carries a head."""
    color = SUPPORT_COLORS[kind]
    return {
        "type": "scatter",
        "x": [x for tail, head in ends for x in (tail[0], head[0], None)],
        "y": [y for tail, head in ends for y in (tail[1], head[1], None)],
        "mode": "lines+markers",
        "line": {"color": color, "width": 2, "backoff": [0, NODE_PX / 2, 0] * len(ends)},
        "marker": {
            "symbol": "arrow",
            "angleref": "previous",
            "color": color,
            "size": [0, 15, 0] * len(ends),
            "standoff": [0, NODE_PX / 2, 0] * len(ends),
        },
        "hoverinfo": "skip",
        "name": f"{kind.name.lower()} ({len(ends)})",
        "showlegend": True,
    }


def _ground(place: Place) -> dict[str, Any]:
    width, height = 34, 17
    return {
        "type": "circle",
        "xref": "x",
        "yref": "y",
        "xsizemode": "pixel",
        "ysizemode": "pixel",
        "xanchor": place[0],
        "yanchor": place[1],
        "x0": -width,
        "x1": width,
        "y0": -height,
        "y1": height,
        "line": {"color": GREEN, "width": 2, "dash": "dash"},
        "fillcolor": "white",
        "label": {"text": "ground", "font": {"color": GREEN, "size": 12}},
    }
