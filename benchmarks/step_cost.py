"""The cost of a step of a search against the number of objects: python -m benchmarks.step_cost --out steps.json.

A step merges one of many equal cubes with the one beside it. Cubes stand in rows, so far apart that each is an
island, or so near that all of them are one.
"""

from __future__ import annotations

import argparse
import json
import math
import statistics
import time
from pathlib import Path
from typing import Any
from unittest.mock import patch

import torch
from torch import Tensor

from blockstab.boxes import box_cache
from blockstab.boxes.box import Boxes
from blockstab.boxes.separation import Separation, separation
from blockstab.commands.warm_up import warm_up
from blockstab.energy.overlap import expected_overlap
from blockstab.output.export import write_whole
from blockstab.scene.inference import Rules
from blockstab.search.problem import problem_of
from blockstab.testing.photographs import photograph
from blockstab.testing.worlds import Block
from models.potentials.parsing import parsing_potentials
from tests.search.watched import CountingFitter, CountingJudge
from tests.synthetic import view_of

COUNTS = (5, 10, 20, 40, 80)
GAPS_M = {"apart": 0.052, "near": 0.01}  # between cubes; islands end at 5 cm
_SIDE_M = 0.02
_STEPS = 30


def cubes(count: int, gap: float) -> list[Block]:
    """So many cubes in as many rows as columns, around the middle of the table."""
    side, pitch = math.ceil(math.sqrt(count)), _SIDE_M + gap
    places = [(k % side - (side - 1) / 2, k // side - (side - 1) / 2) for k in range(count)]
    return [Block(x * pitch, 0, _SIDE_M, _SIDE_M, z=z * pitch, d=_SIDE_M) for x, z in places]


def cost(count: int, gap: float) -> dict[str, Any]:
    """Medians over steps: milliseconds, boxes fitted, gaps measured, boxes judged."""
    view = view_of(photograph(*cubes(count, gap), turn_deg=0.0, finer=4))
    fitter, judge, gaps = CountingFitter(), CountingJudge(), []

    def counted(boxes: Boxes, first: Tensor, second: Tensor) -> Separation:
        gaps.append(len(first))
        return separation(boxes, first, second)

    with patch.object(box_cache, "separation", counted):
        problem = problem_of(
            view, Rules(fitter=fitter, judge=judge), parsing_potentials("trees"), expected_overlap
        )
        start = problem.search_input.start
        problem.rate([start])
        objects = range(1, len(start))  # the table comes first
        steps = [start.merge(k, k + 1) for k in objects[:-1]][:_STEPS]
        found = []
        for step in steps:
            tallies = (fitter.free, fitter.refits, gaps, judge.asked)
            before = list(map(sum, tallies))
            begin = time.perf_counter()
            problem.rate([step])
            seconds = time.perf_counter() - begin
            free, again, apart, asked = (sum(t) - b for t, b in zip(tallies, before, strict=True))
            found.append((1e3 * seconds, free + again, apart, asked))
    names = ("milliseconds", "fits", "gaps", "verdicts")
    medians = (round(statistics.median(column), 2) for column in zip(*found, strict=True))
    return {"objects": len(objects), **dict(zip(names, medians, strict=True))}


def main() -> None:
    """Measure, and write what it took."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, required=True)
    asked = parser.parse_args()
    torch.set_num_threads(1)
    warm_up()
    rows = []
    for name, gap in GAPS_M.items():
        for count in COUNTS:
            rows.append({"cubes": name, "gap_m": gap, **cost(count, gap)})
            print(rows[-1], flush=True)
    write_whole(asked.out, (json.dumps({"rows": rows}, indent=1) + "\n").encode())


if __name__ == "__main__":
    main()
