"""Compare methods: predict scenes to disk, then score the files. `python evaluate.py experiment=table4`."""

from __future__ import annotations

import json
import time
from collections.abc import Callable
from itertools import groupby
from pathlib import Path
from typing import Any

import hydra
import torch
from joblib import delayed
from omegaconf import DictConfig
from rich.console import Console
from rich.progress import track
from rich.table import Table

import blockstab
from blockstab.datasets.readable import readable
from blockstab.datasets.splits import scenes_of
from blockstab.evaluation.comparison import Comparison, Method
from blockstab.evaluation.scoring.rows import Scored, rows_of
from blockstab.evaluation.true_boxes import removals_in
from blockstab.executors import each_done
from blockstab.output.export import write_whole
from models.configured import CONFIGS, PARTS, example_maker, made, parser_maker, see_own_code
from models.entry import one_line_errors
from models.gathering import gathered
from models.potentials.judging import judged

# Rows of a table, once it is known of which scenes.
RowMaker = Callable[[Comparison], list[dict[str, Any]]]


@hydra.main(config_path=str(CONFIGS), config_name="evaluate", version_base="1.3")
def main(cfg: DictConfig) -> None:
    """Run every method of an experiment on every scene of a data set."""
    see_own_code()
    with one_line_errors():
        run(cfg)


def run(cfg: DictConfig) -> None:
    """Predict, score, and write `results.json`."""
    begin = time.perf_counter()
    data, split, out = made(cfg.data), made(cfg.split), Path(cfg.out)
    # All are made before any of them works: a misspelt one stops here, not after hours.
    prepared: RowMaker = made(cfg.experiment.shows)(cfg)
    chosen = scenes_of(data, split, cfg.part, Path(cfg.splits))
    with made(cfg.executor):
        scenes = readable(data, chosen, cfg.strict, cfg.jobs)
        rows = prepared(Comparison(data, scenes, out, cfg.seed, cfg.jobs, cfg.overwrite))
    results = {
        "experiment": cfg.experiment.name,
        "data": {
            "name": data.name,
            "split": split.name,
            "part": cfg.part,
            "images": len(scenes),
            "left_out": sorted(set(chosen) - set(scenes)),
        },
        "methods": None if cfg.methods is None else list(cfg.methods),
        "rows": rows,
        "seed": cfg.seed,
        "seconds": round(time.perf_counter() - begin, 2),
        "versions": {"blockstab": blockstab.__version__, "torch": torch.__version__},
    }
    out.mkdir(parents=True, exist_ok=True)
    write_whole(out / "results.json", (json.dumps(results, indent=1) + "\n").encode())
    show(results)
    print(f"results in {out / 'results.json'}")


def tables(cfg: DictConfig) -> RowMaker:
    """Rows of the scores of methods."""
    methods = methods_of(cfg)
    return lambda comparison: comparison.table(methods)


def courses(cfg: DictConfig) -> RowMaker:
    """Rows of the course of energy and score in searches."""
    methods = methods_of(cfg)
    return lambda comparison: comparison.courses(methods)


def true_boxes(cfg: DictConfig) -> RowMaker:
    """Rows of judges asked about true boxes."""
    asked = {str(node.name): made(node.judge) for node in chosen_rows(cfg, cfg.experiment.judges).values()}

    def rows(comparison: Comparison) -> list[dict[str, Any]]:
        scenes = comparison.scenes
        work = (delayed(removals_in)(comparison.data, scene, asked) for scene in scenes)
        done = each_done(work, comparison.jobs)
        shown = track(done, "judging", len(scenes), console=Console(stderr=True))
        each = dict(zip(scenes, shown, strict=True))
        names = next(iter(each.values()))
        scores = {name: {scene: found[name] for scene, found in each.items()} for name in names}
        scored = [Scored(name, None, ("falls_any", "falls_set"), some) for name, some in scores.items()]
        return rows_of(scored, comparison.seed)

    return rows


def judges(cfg: DictConfig) -> RowMaker:
    """Rows of the scores of potentials at telling good segments from bad ones."""
    read = parser_maker(cfg).potentials
    potentials = {name: read(path) for name, path in chosen_rows(cfg, cfg.experiment.potentials).items()}
    maker = example_maker(cfg, walks=cfg.experiment.walks, steps=cfg.experiment.steps)

    def rows(comparison: Comparison) -> list[dict[str, Any]]:
        examples = gathered(
            comparison.data,
            comparison.scenes,
            maker,
            comparison.seed,
            comparison.out / "examples",
            comparison.jobs,
            comparison.overwrite,
        )
        return judged(potentials, examples, comparison.seed)

    return rows


def chosen_rows(cfg: DictConfig, rows: DictConfig) -> dict[str, Any]:
    """Those rows of an experiment that `methods` names, in the experiment's order; all where it names none."""
    unknown = sorted(set(cfg.methods or ()) - set(rows))
    if unknown:
        raise ValueError(
            f"{cfg.experiment.name} has no method {unknown[0]!r}; choose from: {', '.join(rows)}."
        )
    return {str(name): rows[name] for name in rows if not cfg.methods or name in cfg.methods}


def methods_of(cfg: DictConfig) -> dict[str, Method]:
    """The methods of an experiment, by the names that its table has for them."""
    maker, methods = parser_maker(cfg), {}
    for key, given in chosen_rows(cfg, cfg.experiment.methods).items():
        strange = sorted(set(given) - {*PARTS, "name", "scores"})
        if strange:
            raise ValueError(
                f"{key} has {strange[0]!r}; a method has a name, scores and any of {', '.join(PARTS)}."
            )
        scores = tuple(given.get("scores") or cfg.experiment.get("scores", ()))
        parts = {part: given[part] for part in PARTS if part in given}
        methods[str(given.get("name", key))] = Method(maker(cfg, parts), scores)
    return methods


def show(results: dict[str, Any]) -> None:
    """Print a table for each group of rows with the same scores, a line for each method and one for its step."""
    console = Console(width=110)
    print(
        f"{results['experiment']}: {results['data']['images']} scenes; means over all that was scored, and steps "
        "over the row above; 95 % intervals"
    )
    for names, rows in groupby(results["rows"], key=lambda row: tuple(row["scores"])):
        lines = Table("method", *names)
        for row in rows:
            lines.add_row(row["method"], *(_cell(row, name) for name in names))
        console.print(lines)


def _cell(row: dict[str, Any], name: str) -> str:
    value, step = row["scores"].get(name), row.get("step", {}).get(name)
    if value is None:
        return ""
    low, high = row["ci95"][name]
    cell = f"{value:.3f}  [{low:.3f}, {high:.3f}]"
    if step is not None:
        low, high = row["step_ci95"][name]
        cell += f"\n{step:+.3f}  [{low:+.3f}, {high:+.3f}]"
    return cell
