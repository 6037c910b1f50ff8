"""One parse as a page that opens from disk: pictures, boxes to turn, supports, numbers."""

from __future__ import annotations

import json
from html import escape
from importlib.resources import files
from string import Template

from blockstab.output.figures.boxes import boxes_figure
from blockstab.output.figures.figure import division
from blockstab.output.figures.images import depth_figure, energy_figure, segments_figure
from blockstab.output.figures.marks import RED, in_words, margin_mm, segment_colors, state
from blockstab.output.figures.supports import support_figure
from blockstab.parsing.parsed import Parsed
from blockstab.stability.support import GROUND, SupportType
from blockstab.stability.taking_apart import Reason

UNSURE = 0.5  # below this confidence of the up direction the page warns

_WORDS = {
    Reason.SUPPORT: "loses its support",
    Reason.COUNTERWEIGHT: "loses what held it down",
    Reason.NEIGHBOUR: "loses what falls too",
}
_HEADINGS = (
    "id",
    "pixels",
    "size, cm",
    "state",
    "margin, mm",
    "badness",
    "supported by",
    "falls if removed",
    "taken away as",
)


def report_html(parsed: Parsed) -> str:
    """The whole page, plotly.js included: it needs no network and no other file."""
    from plotly.offline import get_plotlyjs

    figures = {
        "segments": segments_figure(parsed),
        "depth": depth_figure(parsed),
        "boxes": boxes_figure(parsed),
        "support": support_figure(parsed),
        "energy": energy_figure(parsed),
    }
    page = Template(files("blockstab.output").joinpath("report.html").read_text(encoding="utf-8"))
    return page.substitute(
        name=escape(parsed.name),
        red=RED,
        plotly_js=get_plotlyjs(),
        summary=escape(_summary(parsed)),
        notes="".join(f'<p class="unsure">{escape(note)}</p>' for note in _notes(parsed)),
        table=_table(parsed),
        order=escape(_order(parsed)),
        because=json.dumps(_because(parsed)),
        footer=escape(_footer(parsed)),
        **{key: division(figure, key, key == "boxes") for key, figure in figures.items()},
    )


def _summary(parsed: Parsed) -> str:
    objects = ~parsed.scene.background
    unstable = int((objects & ~parsed.scene.balance.stable).sum())
    count = int(objects.sum())
    return " · ".join(
        (
            f"{count} object{'s' if count != 1 else ''}",
            f"{unstable} unstable",
            f"energy {parsed.energy:.3f}",
            f"{sum(parsed.seconds.values()):.1f} s",
            f"up known with confidence {parsed.scene.ground.confidence:.2f}",
        )
    )


def _notes(parsed: Parsed) -> list[str]:
    notes = []
    if parsed.scene.ground.confidence < UNSURE:
        notes.append(
            "The up direction is unsure: supports and stability below may be wrong. "
            "Check that the boxes stand upright, or give the direction in meta.json."
        )
    if parsed.scene.ground.height is None:
        notes.append("No ground plane was found: the lowest points are taken to lie on it.")
    return notes


def _footer(parsed: Parsed) -> str:
    stages = ", ".join(f"{stage} {seconds:.2f} s" for stage, seconds in parsed.seconds.items())
    potentials = f"{parsed.potentials_name} (sha256 {parsed.potentials_sha256})"
    return f"{stages}. Potentials: {potentials}. Judge: {parsed.judge}. Seed {parsed.seed}."


def _order(parsed: Parsed) -> str:
    if parsed.removal.order is None:
        return "There is no order in which all can be taken away one at a time while nothing falls."
    names = ", ".join(str(parsed.ids[i]) for i in parsed.removal.order)
    if not names:
        return ""
    return f"Taken away in this order, one at a time, as the small numbers say, nothing falls: {names}."


def _because(parsed: Parsed) -> dict[str, dict[str, str]]:
    """By id, by the id of what falls without it, why, in words."""
    found: dict[str, dict[str, str]] = {
        str(identity): {}
        for identity, background in zip(parsed.ids, parsed.scene.background.tolist(), strict=True)
        if not background
    }
    for (taken, fallen), reason in sorted(parsed.removal.reasons.items()):
        found.setdefault(str(parsed.ids[taken]), {})[str(parsed.ids[fallen])] = _WORDS[reason]
    return found


def _table(parsed: Parsed) -> str:
    """Objects first, then background, each in the order of the segments."""
    order = sorted(range(len(parsed.scene)), key=lambda i: bool(parsed.scene.background[i]))
    rows = "\n".join(_row(parsed, i) for i in order)
    head = "".join(f"<th{_class(h)}>{h}</th>" for h in _HEADINGS)
    return f"<table>\n<thead><tr>{head}</tr></thead>\n<tbody>\n{rows}\n</tbody>\n</table>"


def _row(parsed: Parsed, i: int) -> str:
    scene, kind = parsed.scene, state(parsed, i)
    sides = (200 * scene.boxes.half_extent[i]).sort(descending=True).values.tolist()
    margin = margin_mm(scene, i)
    order = parsed.removal.order or ()
    supporters = (scene.supports.supported == i).nonzero().flatten().tolist()
    cells = (
        f'<span class="swatch" style="background:{segment_colors(scene)[i]}"></span>{parsed.ids[i]}',
        str(int(scene.pixel_count[i])),
        " x ".join(f"{side:.1f}" for side in sides),
        in_words(kind),
        "" if margin is None else f"{margin:.1f}",
        f"{float(parsed.badness[i]):.2f}",
        ", ".join(_supporter(parsed, e) for e in supporters),
        ", ".join(str(parsed.ids[j]) for j in parsed.removal.falls.get(i, ())),
        str(order.index(i) + 1) if i in order else "",
    )
    columns = zip(_HEADINGS, cells, strict=True)
    row = "".join(f"<td{_class(h)}>{cell}</td>" for h, cell in columns)
    return f'<tr class="{kind}" data-id="{parsed.ids[i]}">{row}</tr>'


def _supporter(parsed: Parsed, edge: int) -> str:
    supports = parsed.scene.supports
    index, kind = int(supports.supporter[edge]), SupportType(int(supports.type[edge]))
    if index == GROUND and int(supports.supported[edge]) in parsed.unseen:
        return "something unseen"
    return f"{'ground' if index == GROUND else parsed.ids[index]} ({kind.name.lower()})"


def _class(heading: str) -> str:
    return ' class="words"' if heading in ("state", "supported by", "falls if removed") else ""
