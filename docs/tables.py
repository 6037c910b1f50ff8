"""Write the tables of the pages and the README from docs/results; with --check, say if they are old."""

from __future__ import annotations

import json
import re
import sys
from collections.abc import Callable
from itertools import groupby
from pathlib import Path
from typing import Any

RESULTS = Path(__file__).with_name("results")
START, END = "<!-- tables -->\n", "<!-- end of tables -->"

# Tables 2, 3 and 4 of the paper, on its own data sets.
PAPER = {
    ("axis_error_deg", "Min-vol"): "15.41° (Block)",
    ("axis_error_deg", "Min-surf"): "9.75° (Block)",
    ("axis_error_deg", "Supp-surf"): "7.02° (Block)",
    ("support_accuracy", "Neighbour"): "80.6 % (Block), 52.9 % (SOD)",
    ("support_accuracy", "Stability reasoning"): "91.7 % (Block), 72.9 % (SOD)",
    ("overlap", "Silberman"): "60.2 % (SOD), 65.9 % (GD), 60.1 % (NYU)",
    ("overlap", "S/P"): "64.7 % (SOD), 68.1 % (GD), 60.8 % (NYU)",
    ("overlap", "Stability"): "66.7 % (SOD), 69.2 % (GD), 61.0 % (NYU)",
    **dict.fromkeys(
        (("overlap", "R-Samp"), ("overlap", "R-Samp as printed")), "70.0 % (SOD), 72.3 % (GD), 61.7 % (NYU)"
    ),
}
# How many digits a score has, of what, and what it is multiplied with; of others, as of shares.
UNITS = {"axis_error_deg": (2, "°", 1), "atoms": (0, "", 1), "rank_correlation": (2, "", 1)}
# Results that more than one command makes.
MADE_BY = {
    "demo": "make demo",
    **dict.fromkeys(("figure13_blocks", "figure13_grocery", "figure13_objects"), "make figures"),
    "table4_osd_folds": "make folds OSD=osd",
    **dict.fromkeys(
        ("proposals_osd", "proposals_objects", "atoms_osd", "atoms_objects"), "make proposals OSD=osd"
    ),
}
OWN_POTENTIALS = ("table4", "potentials")  # experiments that name them
SCORES = {"table4": ["overlap", "overlap_f", "boundary_f"]}  # of experiments that may be asked for others
NONE = """\
No results are stored yet. Run `evaluate.py`, copy its `results.json` to `docs/results/` under a name of its own, and
run `python docs/tables.py`.
"""


def tables(files: list[Path]) -> str:
    """A table for each file of results, in the order given."""
    return "\n".join(_section(file.stem, json.loads(file.read_text())) for file in files) or NONE


def _section(name: str, results: dict[str, Any]) -> str:
    versions = ", ".join(f"{package} {version}" for package, version in results["versions"].items())
    command = MADE_BY.get(name) or _command(results)
    groups = groupby(results["rows"], key=lambda row: tuple(row["scores"]))
    return f"## {name}\n\n    {command}\n\n{results['data']['images']} images, {versions}.\n\n" + "\n".join(
        _table(list(rows)) for _, rows in groups
    )


def _command(results: dict[str, Any]) -> str:
    """The command that such results come from."""
    name = results["data"]["name"]
    simulated = re.fullmatch(r"([a-z]+)_(\d+)_seed(\d+)_([a-z]+)_variety([\d.]+)(?:_(support|let_go))?", name)
    if simulated:
        keys = ("preset", "count", "seed", "sensor", "variety", "way")
        given = {k: v for k, v in zip(keys, simulated.groups(), strict=True) if v is not None}
        kind = "spoilt" if "way" in given else "simulated"
        data = " ".join([f"data={kind}", *(f"data.{k}={v}" for k, v in given.items())])
    else:
        root = name.removesuffix(" (annotated)")
        data = f"data=folder data.root={root}" + (" data.annotated=true" if root != name else "")
    first = results["rows"][0]["potential"]
    chosen = "" if first is None or results["experiment"] in OWN_POTENTIALS else f" potentials={first}"
    some = results.get("methods")
    methods = f" 'methods=[{','.join(some)}]'" if some else ""
    asked, usual = list(results["rows"][0]["scores"]), SCORES.get(results["experiment"])
    scores = f" 'experiment.scores=[{','.join(asked)}]'" if usual and asked != usual else ""
    experiment, seed = results["experiment"], results["seed"]
    return f"python evaluate.py experiment={experiment} {data}{chosen} seed={seed}{methods}{scores}"


def _table(rows: list[dict[str, Any]]) -> str:
    columns: list[tuple[str, Callable[[dict[str, Any], str], str]]] = []
    for score in dict.fromkeys(score for row in rows for score in row["scores"]):
        columns.append((score, _mean))
        if any(row.get("step", {}).get(score) is not None for row in rows):
            columns.append((score, _step))
        if any((score, row["method"]) in PAPER for row in rows):
            columns.append((score, _paper))
    heads = {_mean: "{}", _step: "step", _paper: "{} in the paper"}
    lines = [
        ["method", *(heads[cell].format(score) for score, cell in columns)],
        ["---"] * (len(columns) + 1),
        *([row["method"], *(cell(row, score) for score, cell in columns)] for row in rows),
    ]
    return "".join(f"| {' | '.join(line)} |\n" for line in lines)


def _mean(row: dict[str, Any], score: str) -> str:
    """A mean and its interval."""
    mean = row["scores"].get(score)
    return "" if mean is None else _with_interval(mean, row["ci95"][score], score, "")


def _step(row: dict[str, Any], score: str) -> str:
    """The step over the row above, and its paired interval."""
    step = row.get("step", {}).get(score)
    return "" if step is None else _with_interval(step, row["step_ci95"][score], score, "+")


def _paper(row: dict[str, Any], score: str) -> str:
    """What the paper has in this place."""
    return PAPER.get((score, row["method"]), "") if score in row["scores"] else ""


def _with_interval(mean: float, interval: list[float], score: str, sign: str) -> str:
    digits, unit, scale = UNITS.get(score, (1, " %", 100))
    first, *both = (f"{scale * number:{sign}.{digits}f}" for number in (mean, *interval))
    return f"{first}{unit} [{', '.join(both)}]"


def census(files: list[Path]) -> str:
    """One table of the counts of simulated sets, a line for each file `<preset>_<count>_seed<seed>.json`."""
    lines = [
        "| set | scenes | objects | in a scene | on other objects | scenes in which something can be felled |"
    ]
    lines.append("|---|---|---|---|---|---|")
    for file in files:
        found = json.loads(file.read_text())
        preset, count, seed = re.fullmatch(r"([a-z]+)_(\d+)_seed(\d+)", file.stem).groups()  # type: ignore[union-attr]
        stacked, felling = (f"{100 * found[share]:.0f} %" for share in ("on_objects", "felling"))
        lines.append(
            f"| `--preset {preset} --count {count} --seed {seed}` | {found['scenes']} | {found['objects']} "
            f"| {found['fewest']} to {found['most']} | {stacked} | {felling} |"
        )
    return "\n".join(lines) + "\n"


def speed(files: list[Path]) -> str:
    """What whole parses and steps of searches take, a table for each file."""
    return "\n".join(SPEED[file.stem](json.loads(file.read_text())["rows"]) for file in files)


def _whole_images(rows: list[dict[str, Any]]) -> str:
    """A line for each set, version and number of jobs; seconds are median and greatest."""
    stages = list(next(row["stages"] for row in rows if row["stages"]))
    lines = [
        f"| set | code | jobs | {' | '.join(stages)} | all | memory |",
        "|---" * (len(stages) + 5) + "|",
    ]
    for row in rows:
        run = f"| {row['set']} ({row['scenes']}) | {row['code']} | {row['jobs']} | "
        if row["stages"] is None:
            lines.append(run + "breaks | " + " |" * (len(stages) + 1))
            continue
        seconds = " | ".join("{:.2f}, {:.2f} s".format(*row["stages"][stage]) for stage in stages)
        lines.append(f"{run}{seconds} | {row['wall_s']:.0f} s | {row['peak_mib']} MiB |")
    return "\n".join(lines) + "\n"


def _step_cost(rows: list[dict[str, Any]]) -> str:
    lines = [
        "| cubes | objects | time | boxes fitted | gaps measured | verdicts |",
        "|---|---|---|---|---|---|",
    ]
    for row in rows:
        lines.append(
            f"| {row['cubes']}, {100 * row['gap_m']:.1f} cm | {row['objects']} | {row['milliseconds']:.0f} ms "
            f"| {row['fits']:.0f} | {row['gaps']:.0f} | {row['verdicts']:.0f} |"
        )
    return "\n".join(lines) + "\n"


SPEED = {"step_cost": _step_cost, "whole_images": _whole_images}

# Each page, the files that it shows, and how.
PAGES: dict[Path, tuple[str, Callable[[list[Path]], str]]] = {
    Path(__file__).with_name("results.md"): ("*.json", tables),
    Path(__file__).with_name("datasets.md"): ("sets/*.json", census),
    Path(__file__).with_name("speed.md"): ("speed/*.json", speed),
    Path(__file__).parents[1] / "README.md": ("demo.json", tables),
}


def main(check: bool) -> int:
    """Bring the pages up to date, or find out whether they are; the exit status."""
    old = 0
    for page, (files, shown) in PAGES.items():
        text = page.read_text(encoding="utf-8")
        before, rest = text.split(START)
        after = rest.split(END)[1]
        wanted = f"{before}{START}\n{shown(sorted(RESULTS.glob(files)))}\n{END}{after}"
        if check and wanted != text:
            print(f"{page} is out of date; run: python docs/tables.py", file=sys.stderr)
            old = 1
        elif wanted != text:
            draft = page.with_suffix(".tmp")
            draft.write_text(wanted, encoding="utf-8")
            draft.replace(page)
    return old


if __name__ == "__main__":
    sys.exit(main("--check" in sys.argv[1:]))
