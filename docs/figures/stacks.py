"""Draw docs/figures/stacks.svg: python docs/figures/stacks.py SCENE SCENE ...

A row for each labelled scene folder, of its true segments as the camera sees them. Left: boxes as they were seen,
dashed where they were completed, with the removal order. Right: what falls, red, without the thing that fells most,
blue. No pixel of the image is shown.
"""

from __future__ import annotations

import argparse
from html import escape
from pathlib import Path

import torch
from torch import Tensor

from blockstab.boxes.box import Boxes
from blockstab.parsing.parsed import Parsed
from blockstab.rgbd.frame import read_scene
from blockstab.scene.completion import Verdict
from models.configured import composed, parser_maker

TARGET = Path(__file__).with_suffix(".svg")
WIDTH, GAP, TITLE = 380, 16, 24  # pixels of a panel, between panels, and above each
BLUE, RED, GREY, BLACK = "#1f77b4", "#d62728", "#b0b0b0", "#333333"
MARGIN = 0.12  # of the extent of all boxes, around them


def panels(parsed: Parsed) -> tuple[str, str, float]:
    """Both panels of a scene, without their place, and their height."""
    objects = (~parsed.scene.background).nonzero()[:, 0].tolist()
    seen, whole = in_image(parsed, parsed.seen), in_image(parsed, parsed.scene.boxes)
    corners = whole[objects].flatten(0, 2)
    low, high = corners.amin(dim=0), corners.amax(dim=0)
    scale = WIDTH / float((high - low)[0] * (1 + 2 * MARGIN))
    shift = low - MARGIN * (high - low)
    seen, whole = (seen - shift) * scale, (whole - shift) * scale
    order, falls = parsed.removal.order or (), parsed.removal.falls
    taken = max(objects, key=lambda i: len(falls[i]))
    left, right = [], []
    for i in objects:
        if parsed.verdict[i] == Verdict.COMPLETED:
            left.append(lines(whole[i], BLUE, "4 3"))
        left.append(lines(seen[i], RED if parsed.verdict[i] == Verdict.UNSTABLE else BLACK))
        color = BLUE if i == taken else RED if i in falls[taken] else GREY
        right.append(lines(whole[i], color))
    for i in objects:
        x, y = whole[i].flatten(0, 1).mean(dim=0).tolist()
        place = f" ({order.index(i) + 1}.)" if i in order else ""
        left.append(label(x, y, f"{parsed.ids[i]}{place}"))
        right.append(label(x, y, str(parsed.ids[i])))
    fallen = ", ".join(str(parsed.ids[j]) for j in falls[taken]) or "nothing"
    heads = f"{parsed.name}: boxes, and when each can go", f"without {parsed.ids[taken]} falls: {fallen}"
    body = [
        "".join([label(WIDTH / 2, -8, head), *part]) for head, part in zip(heads, (left, right), strict=True)
    ]
    return body[0], body[1], float((high - low)[1] * (1 + 2 * MARGIN)) * scale


def in_image(parsed: Parsed, boxes: Boxes) -> Tensor:
    """(N, 12, 2, 2) the ends of the edges of boxes in the image, columns and rows."""
    points = boxes.edges() @ parsed.scene.ground.world_from_camera
    camera = parsed.frame.camera
    depth = points[..., 2].clamp(min=0.05)
    return torch.stack(
        [camera.fx * points[..., 0] / depth + camera.cx, camera.fy * points[..., 1] / depth + camera.cy],
        dim=-1,
    )


def lines(edges: Tensor, color: str, dash: str = "none") -> str:
    """Edges (12, 2, 2) as one path."""
    path = " ".join(f"M{a[0]:.1f} {a[1]:.1f}L{b[0]:.1f} {b[1]:.1f}" for a, b in edges.tolist())
    return f'<path d="{path}" fill="none" stroke="{color}" stroke-width="1.3" stroke-dasharray="{dash}"/>'


def label(x: float, y: float, text: str) -> str:
    """Words around a place."""
    return f'<text x="{x:.1f}" y="{y:.1f}">{escape(text)}</text>'


def main() -> None:
    """Draw the scenes that the command names."""
    words = argparse.ArgumentParser(description=__doc__)
    words.add_argument("scenes", nargs="+", type=Path)
    cfg = composed("parse", ["proposals=labels", "search=none"], {})
    parser = parser_maker(cfg)(cfg)
    rows, top = [], 0.0
    for folder in words.parse_args().scenes:
        left, right, height = panels(parser(read_scene(folder)))
        top += TITLE
        rows.append(f'<g transform="translate({GAP} {top:.1f})">{left}</g>')
        rows.append(f'<g transform="translate({2 * GAP + WIDTH} {top:.1f})">{right}</g>')
        top += height + GAP
    size = f'width="{2 * WIDTH + 3 * GAP}" height="{top:.0f}"'
    style = "text{font:12px sans-serif;text-anchor:middle;fill:#111}"
    head = f'<svg xmlns="http://www.w3.org/2000/svg" {size}><style>{style}</style>'
    TARGET.write_text(f'{head}<rect {size} fill="white"/>\n' + "\n".join(rows) + "\n</svg>\n")


if __name__ == "__main__":
    main()
