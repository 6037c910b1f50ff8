"""Boundary adherence of atoms: python -m benchmarks.atoms --root osd --out atoms_osd.json."""

from __future__ import annotations

import argparse
import json
import time
from functools import partial
from pathlib import Path
from typing import Any

import torch
from joblib import delayed
from rich.console import Console
from rich.progress import track

import blockstab
from blockstab.datasets.sets import FolderScenes
from blockstab.evaluation.metrics import boundary_recall, inner_border, undersegmentation_error
from blockstab.evaluation.scoring import Score
from blockstab.evaluation.scoring.prediction import object_ids
from blockstab.evaluation.scoring.rows import Scored, rows_of
from blockstab.executors import each_done
from blockstab.observation import estimated_ground, observe
from blockstab.output.export import write_whole

NAMES = ("boundary_recall", "undersegmentation_error", "atoms")


def scored(scene: str, data: FolderScenes) -> dict[str, float]:
    """The scores of the atoms of one scene; its objects alone are meant."""
    torch.set_num_threads(1)
    frame, truth = data.read(scene)
    if frame.label is None:
        raise ValueError(f"{frame.name} has no label.png; there is nothing to score against.")
    fine = observe(frame, estimated_ground).fine
    recall = boundary_recall(inner_border(frame.label, object_ids(frame, truth)), fine)
    return dict(
        zip(NAMES, (recall, undersegmentation_error(frame.label, fine), float(fine.max())), strict=True)
    )


def results(data: FolderScenes, jobs: int) -> dict[str, Any]:
    """In the form of `evaluate.py`."""
    begin, scenes = time.perf_counter(), data.scenes()
    done = each_done((delayed(partial(scored, data=data))(s) for s in scenes), jobs)
    per_image = dict(
        zip(scenes, track(done, "atoms", len(scenes), console=Console(stderr=True)), strict=True)
    )
    scores = {
        scene: {name: Score(value, 1) for name, value in found.items()} for scene, found in per_image.items()
    }
    return {
        "experiment": "atoms",
        "data": {"name": data.name, "split": "whole", "part": "all", "images": len(scenes), "left_out": []},
        "rows": rows_of([Scored("Atoms", None, NAMES, scores)], seed=0),
        "seed": 0,
        "seconds": round(time.perf_counter() - begin, 2),
        "versions": {"blockstab": blockstab.__version__, "torch": torch.__version__},
    }


def main() -> None:
    """Measure, print, and write a file of results."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--root", required=True, type=Path, help="folder of scene folders")
    parser.add_argument("--out", required=True, type=Path)
    parser.add_argument("--jobs", type=int, default=2)
    asked = parser.parse_args()
    found = results(FolderScenes(asked.root), asked.jobs)
    asked.out.parent.mkdir(parents=True, exist_ok=True)
    write_whole(asked.out, (json.dumps(found, indent=1) + "\n").encode())
    print(", ".join(f"{name} {value:.4g}" for name, value in found["rows"][0]["scores"].items()))


if __name__ == "__main__":
    main()
