"""Seconds and memory of whole parses: python -m benchmarks.whole_images --set osd=osd --out out/whole_images.json.

Every set of scene folders is parsed by `blockstab parse` of one checkout or of several, such as an older one beside
this, with one job and with two. Stages are those that `scene.json` tells; memory is the most that one process held.
A run that was stopped goes on where it was.
"""

from __future__ import annotations

import argparse
import json
import os
import statistics
import subprocess
import sys
import time
from collections.abc import Sequence
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from blockstab.output.export import write_whole

HERE = Path(__file__).resolve().parents[1]
PARSE = "from blockstab.cli import main; main()"
KEYS = ("set", "scenes", "code", "jobs")  # which run a row is of; what is in the file is not run again
# Older versions told the three stages before the search in one.
BEFORE_SEARCH = ("segments", "observation", "proposal", "pool")


def run_of(checkout: Path, scenes: Sequence[Path], jobs: int) -> dict[str, Any]:
    """Parse scenes by the code of a checkout; what that took.

    Returns:
        `seconds`, by stage, of each scene; `wall_s` of all, start-up included; `cpu_s`; `peak_mib` of the largest
        process.

    Raises:
        subprocess.CalledProcessError: a scene could not be parsed.
    """
    command = [sys.executable, "-W", "ignore", "-c", PARSE, "parse", *map(str, scenes), "--jobs", str(jobs)]
    environment = {**os.environ, "PYTHONPATH": str(checkout), "OMP_NUM_THREADS": "1"}
    with TemporaryDirectory() as out:
        begin = time.perf_counter()
        child = subprocess.Popen(
            [*command, "--out", out], cwd=checkout, env=environment, stderr=subprocess.DEVNULL
        )
        _, status, used = os.wait4(child.pid, 0)
        wall = time.perf_counter() - begin
        if status:
            raise subprocess.CalledProcessError(status, command)
        seconds = [json.loads((Path(out) / s.name / "scene.json").read_text())["seconds"] for s in scenes]
    return {
        "seconds": [_stages(found) for found in seconds],
        "wall_s": round(wall, 2),
        "cpu_s": round(used.ru_utime + used.ru_stime, 2),
        "peak_mib": round(used.ru_maxrss / 1024),
    }


def _stages(found: dict[str, float]) -> dict[str, float]:
    early = sum(found.get(stage, 0.0) for stage in BEFORE_SEARCH)
    late = found["removal"] + found.get("conclusion", 0.0)  # which older versions have not
    stages = {"before the search": early, "search": found["search"], "removal": late}
    return {**stages, "whole image": sum(stages.values())}


def summary(run: dict[str, Any]) -> dict[str, Any]:
    """Median and greatest seconds of each stage, and what else there is of a run."""
    stages = {
        stage: [round(of([s[stage] for s in run["seconds"]]), 3) for of in (statistics.median, max)]
        for stage in run["seconds"][0]
    }
    return {"stages": stages, **{name: run[name] for name in ("wall_s", "cpu_s", "peak_mib")}}


def named(text: str) -> tuple[str, Path]:
    """A name and a folder, from `name=folder`."""
    name, _, path = text.partition("=")
    return name, Path(path).resolve()


def main() -> None:
    """Parse every set by every checkout, and write what it took."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument(
        "--set", type=named, action="append", required=True, help="name=folder of scene folders"
    )
    parser.add_argument(
        "--checkout", type=named, action="append", help="name=folder of code; if none, this one"
    )
    parser.add_argument("--jobs", type=int, nargs="+", default=[1, 2])
    parser.add_argument("--out", type=Path, required=True)
    asked = parser.parse_args()
    rows = json.loads(asked.out.read_text())["rows"] if asked.out.is_file() else []
    done = [[row[key] for key in KEYS] for row in rows]
    for name, folder in asked.set:
        scenes = sorted(file.parent for file in folder.glob("*/meta.json"))
        for code, checkout in asked.checkout or [("now", HERE)]:
            for jobs in asked.jobs:
                if [name, len(scenes), code, jobs] in done:
                    continue
                try:
                    found = summary(run_of(checkout, scenes, jobs))
                except subprocess.CalledProcessError:
                    found = {"stages": None}  # as where an older version breaks on an image
                rows.append({**dict(zip(KEYS, (name, len(scenes), code, jobs), strict=True)), **found})
                print(rows[-1], flush=True)
                write_whole(asked.out, (json.dumps({"rows": rows}, indent=1) + "\n").encode())


if __name__ == "__main__":
    main()
