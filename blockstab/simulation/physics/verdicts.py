"""Boxes let go where they are put, and which of them the engine sees move: to judge rules of stability by."""

from __future__ import annotations

import json
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np
import torch
from joblib import delayed
from torch import Tensor

from blockstab.boxes.box import Boxes, checked
from blockstab.boxes.separation import separation
from blockstab.output.export import write_whole
from blockstab.rgbd.reading import FrameError, read_meta
from blockstab.simulation.layouts.unsettled import placed_unsettled
from blockstab.simulation.physics.engine import require_mujoco
from blockstab.simulation.physics.settling import moves
from blockstab.simulation.writing import check_amounts, run_all
from blockstab.stability.judges import StabilityJudge, StaticEquilibrium, TrimmedSupports
from blockstab.stability.support import SupportRules, candidate_supports

VERSION = 1  # raised whenever the same seed makes another arrangement than before
_TOUCH = 0.002  # metres; exact boxes that are further apart do not touch
_JUDGES: dict[str, StabilityJudge] = {
    "The paper's rule": TrimmedSupports(),
    "Static equilibrium": StaticEquilibrium(),
}


@dataclass(frozen=True)
class Verdict:
    """N boxes as they were put down, in a frame with +y up and the table at y = 0.

    Args:
        boxes: where each was let go.
        moved: (N,) bool, whether the engine saw it move by 1 cm or turn by 10 degrees.
    """

    boxes: Boxes
    moved: Tensor


def draw_verdict(seed: int, index: int) -> Verdict:
    """Arrangement number `index` of a seed, and what becomes of it."""
    entropy = np.random.SeedSequence((seed, index)).generate_state(1, np.uint64)
    pile = placed_unsettled(torch.Generator().manual_seed(int(entropy[0])))
    return Verdict(pile.boxes(), moves(pile))


def write_verdicts(out: Path, count: int, seed: int, jobs: int = 1) -> list[Path]:
    """Write arrangements 0 to `count - 1` of a seed as `out/verdict_<index>.json`; those that are there are kept.

    Raises:
        ValueError: a number is out of range.
        ModuleNotFoundError: MuJoCo is not installed.
    """
    require_mujoco()
    check_amounts(count, jobs)
    files = [Path(out) / f"verdict_{index:04d}.json" for index in range(count)]
    todo = [i for i, file in enumerate(files) if not _is_made(file, _origin(seed, i))]
    Path(out).mkdir(parents=True, exist_ok=True)
    run_all([delayed(_write_one)(files[i], seed, i) for i in todo], jobs, "judging", count)
    return files


def read_verdict(file: Path) -> Verdict:
    """Read what `write_verdicts` wrote.

    Raises:
        FrameError: the file is damaged.
    """
    values = read_meta(file).values
    try:
        numbers = [
            torch.tensor(values[k], dtype=torch.float64) for k in ("center", "rotation", "half_extent")
        ]
        moved = torch.tensor(values["moved"], dtype=torch.bool)
        boxes = checked(Boxes(*numbers))
        if moved.shape != (len(boxes),):
            raise ValueError(f"moved needs one verdict for each of {len(boxes)} boxes")
    except (KeyError, TypeError, ValueError, RuntimeError, IndexError, OverflowError) as error:
        raise FrameError(
            f"{file}: must hold boxes and a verdict on each, but {error}; make it anew."
        ) from None
    return Verdict(boxes, moved)


def judged(boxes: Boxes, judge: StabilityJudge) -> Tensor:
    """Stability of N exact boxes as a judge sees it, (N,) bool; the table is y = 0."""
    n = len(boxes)
    first, second = torch.triu_indices(n, n, offset=1)
    rules = SupportRules(touch_m=_TOUCH, touch_per_square_m=0.0)
    movable, slack = torch.ones(n, dtype=torch.bool), torch.zeros(n, dtype=torch.float64)
    apart = separation(boxes, first, second)
    candidates = candidate_supports(
        boxes, (first, second), apart, torch.zeros(n, dtype=torch.float64), movable, ~movable, rules
    )
    return judge(boxes, movable, candidates, slack).balance.stable


def summary(files: list[Path]) -> str:
    """Share of arrangements that fall, and agreement of judges with the engine, in one line."""
    verdicts = [read_verdict(file) for file in files]
    falling = sum(bool(v.moved.any()) for v in verdicts) / len(verdicts)
    moved = torch.cat([v.moved for v in verdicts])
    agreements = []
    for name, judge in _JUDGES.items():
        stable = torch.cat([judged(v.boxes, judge) for v in verdicts])
        agreements.append(
            f"{name} calls {float(stable[~moved].double().mean()):.1%} of those that stay stable, "
            f"and {float((~stable[moved]).double().mean()):.1%} of those that move unstable"
        )
    return (
        f"{falling:.0%} of the arrangements fall; of {len(moved)} boxes {float(moved.double().mean()):.0%} move. "
        + ". ".join(agreements)
    )


def _write_one(file: Path, seed: int, index: int) -> None:
    verdict = draw_verdict(seed, index)
    boxes = {name: value.tolist() for name, value in vars(verdict.boxes).items()}
    text = json.dumps(
        {**boxes, "moved": verdict.moved.tolist(), "simulation": _origin(seed, index)}, indent=1
    )
    write_whole(file, (text + "\n").encode())


def _origin(seed: int, index: int) -> dict[str, Any]:
    versions = {name: version(name) for name in ("blockstab", "mujoco")}
    return {"seed": seed, "index": index, "recipe": VERSION, "versions": versions}


def _is_made(file: Path, origin: dict[str, Any]) -> bool:
    if not file.exists():
        return False
    try:
        return bool(json.loads(file.read_text())["simulation"] == origin)
    except (OSError, ValueError, KeyError, TypeError):
        raise ValueError(f"{file} exists and is no arrangement; move it or write elsewhere.") from None
