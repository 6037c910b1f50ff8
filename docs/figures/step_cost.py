"""Draw docs/figures/step_cost.svg: python docs/figures/step_cost.py docs/results/speed/step_cost.json.

The time of a step of a search against the number of objects in the image, both on scales of ratios, beside the line
that a cost in proportion to the objects would follow.
"""

from __future__ import annotations

import argparse
import json
import math
from collections.abc import Sequence
from itertools import groupby
from pathlib import Path
from typing import Any

TARGET = Path(__file__).with_suffix(".svg")
LEFT, TOP, WIDTH, HEIGHT, RIGHT, BOTTOM = 62, 16, 420, 240, 120, 42  # pixels: of the plot, and around it
COLORS = ("#1f5fb4", "#b4531f")
STYLE = (
    "text{font-family:Helvetica,Arial,sans-serif;font-size:12px;fill:#222}"
    ".middle{text-anchor:middle}.right{text-anchor:end}"
)
OBJECTS, MILLISECONDS = (4.0, 100.0), (10.0, 1000.0)  # ends of the axes
TICKS = ((5, 10, 20, 40, 80), (10, 30, 100, 300, 1000))


def place(objects: float, milliseconds: float) -> tuple[float, float]:
    """Pixels from the left and from the top of the drawing."""
    across = math.log(objects / OBJECTS[0]) / math.log(OBJECTS[1] / OBJECTS[0])
    up = math.log(milliseconds / MILLISECONDS[0]) / math.log(MILLISECONDS[1] / MILLISECONDS[0])
    return LEFT + WIDTH * across, TOP + HEIGHT * (1 - up)


def drawing(rows: Sequence[dict[str, Any]]) -> str:
    """The whole SVG."""
    size = f"{LEFT + WIDTH + RIGHT} {TOP + HEIGHT + BOTTOM}"
    kinds = [(name, list(group)) for name, group in groupby(rows, key=lambda row: str(row["cubes"]))]
    return "\n".join(
        [
            f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {size}" role="img" '
            'aria-label="Time of a step of a search against the number of objects">',
            f"<style>{STYLE}</style>",
            f'<rect width="{LEFT + WIDTH + RIGHT}" height="{TOP + HEIGHT + BOTTOM}" rx="8" fill="#fff"/>',
            *_axes(),
            *_curve("in proportion", [(5, 30), (80, 480)], "#999", "stroke-dasharray='5 4'"),
            *(
                part
                for (name, group), color in zip(kinds, COLORS, strict=False)
                for part in _curve(name, [(r["objects"], r["milliseconds"]) for r in group], color)
            ),
            "</svg>\n",
        ]
    )


def _axes() -> list[str]:
    bottom = TOP + HEIGHT
    parts = [
        f'<rect x="{LEFT}" y="{TOP}" width="{WIDTH}" height="{HEIGHT}" fill="none" stroke="#999"/>',
        f'<text class="middle" x="{LEFT + WIDTH / 2}" y="{bottom + 34}">objects in the image</text>',
    ]
    for count in TICKS[0]:
        x, _ = place(count, MILLISECONDS[0])
        parts.append(f'<text class="middle" x="{x:.1f}" y="{bottom + 16}">{count}</text>')
    for time in TICKS[1]:
        _, y = place(OBJECTS[0], time)
        parts.append(f'<text class="right" x="{LEFT - 6}" y="{y + 4:.1f}">{time} ms</text>')
        parts.append(f'<line x1="{LEFT}" x2="{LEFT + WIDTH}" y1="{y:.1f}" y2="{y:.1f}" stroke="#eee"/>')
    return parts


def _curve(name: str, points: Sequence[tuple[float, float]], color: str, more: str = "") -> list[str]:
    places = [place(*point) for point in points]
    line = " ".join(f"{x:.1f},{y:.1f}" for x, y in places)
    x, y = places[-1]
    return [
        f'<polyline points="{line}" fill="none" stroke="{color}" stroke-width="2" {more}/>',
        *(f'<circle cx="{x:.1f}" cy="{y:.1f}" r="3" fill="{color}"/>' for x, y in places if not more),
        f'<text x="{x + 8:.1f}" y="{y + 4:.1f}" style="fill:{color}">{name}</text>',
    ]


def main() -> None:
    """Draw, of a file."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("file", type=Path)
    parser.add_argument("--out", type=Path, default=TARGET)
    asked = parser.parse_args()
    asked.out.write_text(drawing(json.loads(asked.file.read_text())["rows"]), encoding="utf-8")


if __name__ == "__main__":
    main()
