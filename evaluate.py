"""Compare methods: predict scenes to disk, then score the files. `python evaluate.py experiment=blocks`."""

from __future__ import annotations

import json
import time
from functools import partial
from itertools import groupby
from pathlib import Path
from typing import Any

import hydra
import torch
from hydra.utils import instantiate
from omegaconf import DictConfig
from rich.console import Console
from rich.table import Table

import blockstab
from blockstab.batch import Job, parse_all
from blockstab.datasets.readable import readable
from blockstab.datasets.sets import SceneSet
from blockstab.datasets.splits import scenes_of
from blockstab.export import write_whole
from blockstab.parser import Parser
from blockstab.rgbd.frame import Frame
from blockstab.scoring import Score, score_scene
from models.entry import one_line_errors
from models.parsing import parsing_potentials

RESAMPLES = 1000


@hydra.main(config_path="configs", config_name="evaluate", version_base="1.3")
def main(cfg: DictConfig) -> None:
    """Run every method of an experiment on every scene of a data set."""
    with one_line_errors():
        run(cfg)


def run(cfg: DictConfig) -> None:
    """Predict, score, and write `results.json`."""
    begin = time.perf_counter()
    data, split = instantiate(cfg.data), instantiate(cfg.split)
    potentials, out = parsing_potentials(cfg.potentials), Path(cfg.out)
    chosen = scenes_of(data, split, cfg.part, Path(cfg.splits))
    scenes = readable(data, chosen, cfg.strict, cfg.jobs)
    boundaries = instantiate(cfg.boundaries)
    # All are made before any of them works: a misspelt one stops here, not after hours.
    parsers = {
        name: instantiate(method.parser)(potentials=potentials, boundaries=boundaries, seed=cfg.seed)
        for name, method in cfg.experiment.methods.items()
    }
    rows = [
        row_of(name, parser, cfg, data, scenes, out, tuple(cfg.experiment.methods[name].scores))
        for name, parser in parsers.items()
    ]
    results = {
        "experiment": cfg.experiment.name,
        "data": {
            "name": data.name,
            "split": split.name,
            "part": cfg.part,
            "images": len(scenes),
            "left_out": sorted(set(chosen) - set(scenes)),
        },
        "rows": rows,
        "seed": cfg.seed,
        "seconds": round(time.perf_counter() - begin, 2),
        "versions": {"blockstab": blockstab.__version__, "torch": torch.__version__},
    }
    write_whole(out / "results.json", (json.dumps(results, indent=1) + "\n").encode())
    show(results)
    print(f"results in {out / 'results.json'}")


def row_of(
    name: str,
    parser: Parser,
    cfg: DictConfig,
    data: SceneSet,
    scenes: list[str],
    out: Path,
    wanted: tuple[str, ...],
) -> dict[str, Any]:
    """Predict with one method, then score its files."""
    where = out / "predictions" / name
    jobs = [Job(s, partial(frame_of, data, s), partial(data.stamp, s)) for s in scenes]
    failed = [
        o.error for o in parse_all(jobs, parser, parser.settings, where, cfg.jobs, report=False) if o.error
    ]
    if failed:
        raise SystemExit(
            f"{name}: {len(failed)} of {len(jobs)} scenes failed; a score without them would mislead."
        )
    each = {s: score_scene(*data.read(s), where / s, wanted) for s in scenes}
    scores, intervals = {}, {}
    for score in wanted:
        parts = [s[score] for s in each.values() if s[score].things]
        scores[score] = pooled(parts)
        intervals[score] = interval(parts, cfg.seed)
    per_image = {
        scene: {k: s.total / s.things for k, s in found.items() if s.things} for scene, found in each.items()
    }
    return {
        "method": name,
        "potential": parser.potentials.name,
        "scores": scores,
        "ci95": intervals,
        "per_image": per_image,
    }


def frame_of(data: SceneSet, scene: str) -> Frame:
    """The image of one scene."""
    return data.read(scene)[0]


def pooled(parts: list[Score]) -> float | None:
    """The mean over all things scored."""
    return sum(p.total for p in parts) / sum(p.things for p in parts) if parts else None


def interval(parts: list[Score], seed: int) -> list[float] | None:
    """The 95 % bootstrap interval of the pooled mean, over images."""
    if not parts:
        return None
    total = torch.tensor([p.total for p in parts], dtype=torch.float64)
    count = torch.tensor([p.things for p in parts], dtype=torch.float64)
    generator = torch.Generator().manual_seed(seed)
    draws = torch.randint(0, len(parts), (RESAMPLES, len(parts)), generator=generator)
    means = total[draws].sum(dim=1) / count[draws].sum(dim=1)
    return [float(means.quantile(q)) for q in (0.025, 0.975)]


def show(results: dict[str, Any]) -> None:
    """Print a table for each group of rows with the same scores, one line a method."""
    console = Console(width=110)
    print(
        f"{results['experiment']}: {results['data']['images']} scenes; means over all that was scored, 95 % intervals"
    )
    for names, rows in groupby(results["rows"], key=lambda row: tuple(row["scores"])):
        table = Table("method", *names)
        for row in rows:
            table.add_row(row["method"], *(_cell(row, name) for name in names))
        console.print(table)


def _cell(row: dict[str, Any], name: str) -> str:
    value, interval_ = row["scores"].get(name), row["ci95"].get(name)
    return "" if value is None else f"{value:.3f}  [{interval_[0]:.3f}, {interval_[1]:.3f}]"


if __name__ == "__main__":
    main()
