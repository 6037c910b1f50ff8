"""Draw docs/figures/pipeline.svg: the stages of a parse, and what flows between them. Run it after a change."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path
from typing import NamedTuple

TARGET = Path(__file__).with_suffix(".svg")
WIDTH, HEIGHT, STEP_X, STEP_Y, MARGIN = 160, 66, 190, 112, 20
IMAGE, PARTS, GEOMETRY, LEARNED, RESULT = "#e3eefb", "#e4f3e4", "#fdeeda", "#f0e6f7", "#eeeeee"


class Stage(NamedTuple):
    """One box of the drawing: its place in the grid, what it is, what it gives, the file that makes it."""

    column: int
    row: int
    name: str
    gives: str
    file: str
    color: str


STAGES = (
    Stage(0, 0, "Frame", "colour, depth, camera", "rgbd/frame.py", IMAGE),
    Stage(1, 0, "Cloud", "points and normals", "rgbd/cloud.py", IMAGE),
    Stage(2, 0, "Ground", "up, and how high", "rgbd/ground.py", IMAGE),
    Stage(3, 0, "Proposal", "first regions", "proposals/", PARTS),
    Stage(4, 0, "Atoms", "finest partition", "segments/atoms.py", PARTS),
    Stage(4, 1, "Segmentation", "sets of atoms", "segments/segmentation.py", PARTS),
    Stage(3, 1, "Islands", "what may touch", "scene/islands.py", GEOMETRY),
    Stage(2, 1, "Boxes and gaps", "one box a segment", "boxes/box_cache.py", GEOMETRY),
    Stage(1, 1, "Supports", "who may hold whom", "stability/support.py", GEOMETRY),
    Stage(0, 1, "Balance", "what stands, on what", "stability/balance.py", GEOMETRY),
    Stage(0, 2, "Scene", "all of it, in one value", "scene/builder.py", GEOMETRY),
    Stage(1, 2, "Features", "30 a segment, 63 a pair", "features/", LEARNED),
    Stage(2, 2, "Potentials", "lower is better", "models/potentials/heads.py", LEARNED),
    Stage(3, 2, "Energy", "one number (Eq. 2)", "energy/", LEARNED),
    Stage(4, 2, "Search", "the least energy", "search/rsamp.py", PARTS),
    Stage(4, 3, "Removal", "what would fall", "stability/removal.py", GEOMETRY),
    Stage(3, 3, "Files", "labels, record, report", "output/export.py, output/report.py", RESULT),
)
STYLE = (
    "text{font-family:Helvetica,Arial,sans-serif;fill:#222;text-anchor:middle}"
    ".name{font-size:15px;font-weight:bold}.gives{font-size:12px}"
    ".file{font-family:Menlo,Consolas,monospace;font-size:10px;fill:#555}"
    ".flow{stroke:#555;stroke-width:1.6;fill:none;marker-end:url(#tip)}.note{font-size:12px;font-style:italic}"
)
TIP = (
    '<marker id="tip" viewBox="0 0 8 8" refX="7" refY="4" markerWidth="7" markerHeight="7" orient="auto">'
    '<path d="M0 0L8 4L0 8z" fill="#555"/></marker>'
)


def drawing() -> str:
    """The whole SVG."""
    place = {stage.name: (MARGIN + STEP_X * stage.column, MARGIN + STEP_Y * stage.row) for stage in STAGES}
    width = 2 * MARGIN + STEP_X * 4 + WIDTH
    height = 2 * MARGIN + STEP_Y * 3 + HEIGHT
    flows = [_flow(place[a.name], place[b.name]) for a, b in pairwise(STAGES)]
    lines = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" role="img" '
        'aria-label="The stages of a parse, and what flows between them">',
        f"<style>{STYLE}</style><defs>{TIP}</defs>",
        f'<rect width="{width}" height="{height}" rx="8" fill="#fff"/>',
        *flows,
        *_loops(place),
        *(_box(stage, *place[stage.name]) for stage in STAGES),
        "</svg>",
    ]
    return "\n".join(lines) + "\n"


def _box(stage: Stage, x: int, y: int) -> str:
    middle = x + WIDTH // 2
    return (
        f'<rect x="{x}" y="{y}" width="{WIDTH}" height="{HEIGHT}" rx="7" fill="{stage.color}" stroke="#999"/>'
        f'<text class="name" x="{middle}" y="{y + 21}">{stage.name}</text>'
        f'<text class="gives" x="{middle}" y="{y + 39}">{stage.gives}</text>'
        f'<text class="file" x="{middle}" y="{y + 56}">{stage.file}</text>'
    )


def _flow(start: tuple[int, int], end: tuple[int, int]) -> str:
    """An arrow between two boxes that are next to each other."""
    (x, y), (to_x, to_y) = start, end
    if x == to_x:
        middle = x + WIDTH // 2
        return f'<path class="flow" d="M{middle} {y + HEIGHT}V{to_y}"/>'
    height = y + HEIGHT // 2
    return f'<path class="flow" d="M{x + WIDTH * (to_x > x)} {height}H{to_x + WIDTH * (to_x < x)}"/>'


def _loops(place: dict[str, tuple[int, int]]) -> list[str]:
    """The two ways back: boxes are fitted again by how they stand, and a search tries other segmentations."""
    (x, y), (to_x, _) = place["Balance"], place["Boxes and gaps"]
    start, end, over = x + WIDTH // 2, to_x + WIDTH // 2, y - 22
    refit = (
        f'<path class="flow" d="M{start} {y}V{over}H{end}V{y}"/>'
        f'<text class="note" x="{(start + end) // 2}" y="{over - 6}">fit again by how it stands</text>'
    )
    (x, y), (_, to_y) = place["Search"], place["Segmentation"]
    right, below = x + 3 * WIDTH // 4, to_y + HEIGHT
    search = (
        f'<path class="flow" d="M{right} {y}V{below}"/>'
        f'<text class="note" x="{right - 52}" y="{(y + below) // 2 + 4}">split, merge</text>'
    )
    return [refit, search]


if __name__ == "__main__":
    TARGET.write_text(drawing(), encoding="utf-8")
