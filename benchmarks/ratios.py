"""Ratios of our times to those of peers in the same run: python -m benchmarks.ratios out/bench.json.

A ratio of 0.5 takes half the time of the peer. Times of different machines cannot be compared; ratios in one run can.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.table import Table

from blockstab.output.export import write_whole

STORED = Path(__file__).with_name("ratios.json")
SLACK = 1.5  # a ratio that is this many times the stored one is a regression
# What every benchmark of a group is measured against, by the end of its name; the first that a group has.
PEERS = ("open3d", "shapely", "coal", "steps", "scikit_image[felzenszwalb]")

Ratios = dict[str, dict[str, float]]  # by group and benchmark


def ratios_of(run: Mapping[str, Any]) -> Ratios:
    """Ratios of the least times of a run of pytest-benchmark; groups without a peer have none."""
    times: dict[str, dict[str, float]] = {}
    for one in run["benchmarks"]:
        times.setdefault(str(one["group"]), {})[one["name"]] = one["stats"]["min"]
    found: Ratios = {}
    for group, of_group in times.items():
        names = [name for peer in PEERS for name in of_group if _is(peer, name)]
        if names:
            found[group] = {n: t / of_group[names[0]] for n, t in of_group.items() if n != names[0]}
    return found


def _is(peer: str, name: str) -> bool:
    return name.endswith(peer) or name.partition("[")[0].endswith(peer)


def regressions(now: Ratios, stored: Ratios) -> list[str]:
    """A line for each benchmark whose ratio is more than `SLACK` times the stored one."""
    return [
        f"{group}: {name} takes {ratio:.3g} of its peer's time, and took {stored[group][name]:.3g}."
        for group, of_group in now.items()
        for name, ratio in of_group.items()
        if ratio > SLACK * stored.get(group, {}).get(name, float("inf"))
    ]


def main() -> None:
    """Print the ratios beside the stored ones; leave with status 1 on a regression."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("run", type=Path, help="what --benchmark-json wrote")
    parser.add_argument("--store", action="store_true", help="keep these ratios for later runs")
    asked = parser.parse_args()
    now = ratios_of(json.loads(asked.run.read_text()))
    stored: Ratios = json.loads(STORED.read_text()) if STORED.is_file() else {}
    table = Table("group", "benchmark", "of its peer's time", "stored")
    for group, of_group in now.items():
        for name, ratio in of_group.items():
            before = stored.get(group, {}).get(name)
            table.add_row(group, name, f"{ratio:.3g}", "" if before is None else f"{before:.3g}")
    Console(width=150).print(table)
    if asked.store:
        write_whole(STORED, (json.dumps(now, indent=1, sort_keys=True) + "\n").encode())
    elif worse := regressions(now, stored):
        raise SystemExit("\n".join(worse))


if __name__ == "__main__":
    main()
