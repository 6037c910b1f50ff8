"""Colours, places and descriptions of segments, alike in every figure."""

from __future__ import annotations

import torch
from torch import Tensor

from blockstab.parsing.parsed import Parsed
from blockstab.scene.types import Scene

RED, GREY, GREEN = "#d62728", "#8c8c8c", "#2ca02c"
CALM = ("#1f77b4", "#17a398", "#6a5acd", "#4d9f3a", "#00a6d6", "#2e4a7d", "#66a182", "#9467bd", "#1b7837")


def segment_colors(scene: Scene) -> list[str]:
    """A colour for each segment: red if unstable, grey if background, else calm."""
    states = zip(scene.background.tolist(), scene.balance.stable.tolist(), strict=True)
    return [
        GREY if background else CALM[i % len(CALM)] if stable else RED
        for i, (background, stable) in enumerate(states)
    ]


def state(parsed: Parsed, i: int) -> str:
    """The state of segment index `i`: a word of `Verdict`."""
    return str(parsed.verdict[i])


def in_words(kind: str) -> str:
    """A state as one reads it."""
    return kind.replace("_", " ")


def margin_mm(scene: Scene, i: int) -> float | None:
    """Margin of segment index `i` against toppling, millimetres; None where that has no meaning."""
    margin = scene.balance.margin[i]
    return 1000 * float(margin) if margin.isfinite() and not scene.background[i] else None


def describe(parsed: Parsed, i: int) -> str:
    """A few lines on segment index `i`, for the pointer to show."""
    lines = [
        f"<b>{parsed.ids[i]}</b> {in_words(state(parsed, i))}",
        f"badness {float(parsed.badness[i]):.2f}",
    ]
    margin = margin_mm(parsed.scene, i)
    return "<br>".join(lines if margin is None else [*lines, f"margin {margin:.0f} mm"])


def image_middles(parsed: Parsed) -> Tensor:
    """The mean column and row of each segment's pixels, (N, 2)."""
    rows, columns = parsed.label.nonzero(as_tuple=True)
    label = parsed.label[rows, columns]
    ids = torch.tensor(parsed.ids, dtype=torch.long)
    length = int(torch.cat([ids, label]).max()) + 1 if len(ids) else 1
    count = label.bincount(minlength=length).clamp(min=1)
    return torch.stack(
        [label.bincount(weights=w.double(), minlength=length) / count for w in (columns, rows)], dim=1
    )[ids]
