"""Draw docs/figures/energy.svg (paper, Figure 13): python docs/figures/energy.py RESULTS.json RESULTS.json ...

A panel for each file that `evaluate.py experiment=figure13` wrote: the score of the best segmentation after each
round, blue, its energy, green, and how far either is sure to have changed since the first guess.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

TARGET = Path(__file__).with_suffix(".svg")
WIDTH, HEIGHT, MARGIN, TOP, BOTTOM = 250, 150, 52, 44, 40  # pixels: of the plot of a panel, and around it
SCORE, ENERGY = "#1f5fb4", "#2a8a3e"
STYLE = (
    "text{font-family:Helvetica,Arial,sans-serif;font-size:11px;fill:#222}.name{font-size:13px;font-weight:bold}"
    ".middle{text-anchor:middle}.right{text-anchor:end}.curve{fill:none;stroke-width:2}.band{opacity:.18}"
)


class Axis(NamedTuple):
    """A range of values, and the heights that it spans."""

    low: float
    high: float

    def height(self, value: float) -> float:
        """Pixels from the top of the drawing."""
        return TOP + HEIGHT * (self.high - value) / (self.high - self.low)


def drawing(files: Sequence[dict[str, Any]], method: str) -> str:
    """The whole SVG, from results, of one method."""
    step = WIDTH + 2 * MARGIN
    width, height = step * len(files), TOP + HEIGHT + BOTTOM
    return "\n".join(
        [
            f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" role="img" '
            'aria-label="Energy and score after each round of a search">',
            f"<style>{STYLE}</style>",
            f'<rect width="{width}" height="{height}" rx="8" fill="#fff"/>',
            *(part for k, results in enumerate(files) for part in _panel(results, method, k * step + MARGIN)),
            "</svg>\n",
        ]
    )


def _panel(results: dict[str, Any], method: str, left: int) -> list[str]:
    row = next((row for row in results["rows"] if row["method"] == method), None)
    if row is None or "course" not in row:
        raise ValueError(
            f"The results must have a course of {method!r}, but have none; run experiment=figure13."
        )
    middle, bottom = left + WIDTH / 2, TOP + HEIGHT
    correlation = row["scores"]["rank_correlation"]
    rounds = len(row["course"]["energy"]["mean"]) - 1
    return [
        f'<text class="name middle" x="{middle}" y="17">{results["data"]["name"]}</text>',
        f'<text class="middle" x="{middle}" y="33">rank correlation {correlation:.2f}, '
        f"{results['data']['images']} images</text>",
        f'<rect x="{left}" y="{TOP}" width="{WIDTH}" height="{HEIGHT}" fill="none" stroke="#999"/>',
        *_curve(row["course"]["overlap"], left, SCORE, percent=True),
        *_curve(row["course"]["energy"], left, ENERGY, percent=False),
        f'<text x="{left}" y="{bottom + 15}">0</text>',
        f'<text class="right" x="{left + WIDTH}" y="{bottom + 15}">{rounds}</text>',
        f'<text class="middle" x="{middle}" y="{bottom + 15}">round</text>',
        f'<text x="{left}" y="{bottom + 32}" style="fill:{SCORE}">score, %</text>',
        f'<text class="right" x="{left + WIDTH}" y="{bottom + 32}" style="fill:{ENERGY}">energy</text>',
    ]


def _curve(course: dict[str, list[float]], left: int, color: str, percent: bool) -> list[str]:
    """A curve in its band, and the ends of its axis: to the left for the score, to the right for the energy."""
    low, high = min(course["low"]), max(course["high"])
    room = 0.06 * (high - low) or 0.01
    axis = Axis(low - room, high + room)
    last = max(len(course["mean"]) - 1, 1)

    def points(values: Sequence[float]) -> list[str]:
        return [f"{left + WIDTH * k / last:.1f},{axis.height(v):.1f}" for k, v in enumerate(values)]

    band = " ".join([*points(course["high"]), *points(course["low"])[::-1]])
    x, anchor = (left - 5, "right") if percent else (left + WIDTH + 5, "")
    ends = [f"{100 * v:.1f}" if percent else f"{v:.3f}" for v in (high, low)]
    return [
        f'<polygon class="band" points="{band}" fill="{color}"/>',
        f'<polyline class="curve" points="{" ".join(points(course["mean"]))}" stroke="{color}"/>',
        *(
            f'<text class="{anchor}" x="{x}" y="{axis.height(v) + 4:.1f}" style="fill:{color}">{end}</text>'
            for v, end in zip((high, low), ends, strict=True)
        ),
    ]


def main() -> None:
    """Draw, of files."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("files", nargs="+", type=Path)
    parser.add_argument("--method", default="R-Samp")
    parser.add_argument("--out", type=Path, default=TARGET)
    asked = parser.parse_args()
    results = [json.loads(file.read_text()) for file in asked.files]
    asked.out.write_text(drawing(results, asked.method), encoding="utf-8")


if __name__ == "__main__":
    main()
