"""Simulated scenes with exact truth: settled by physics, seen by ray casting, measured by a depth sensor."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np
import torch
from joblib import Parallel, delayed
from rich.console import Console
from rich.progress import Progress
from torch import Tensor

from blockstab.boxes.box import Boxes
from blockstab.datasets.blocks import arrange_blocks
from blockstab.datasets.folder import IMAGES, META, write_scene
from blockstab.datasets.physics import carried_share, falls, require_mujoco, settle
from blockstab.datasets.rendering import TABLE, photograph
from blockstab.datasets.truth import ObjectTruth, Truth
from blockstab.datasets.viewpoint import View, draw_view
from blockstab.rgbd.frame import Frame

Arrangement = Callable[[torch.Generator], Boxes]
PRESETS: dict[str, Arrangement] = {"blocks": arrange_blocks}

RECIPE = 1  # raised whenever the same seed makes another scene than before
_CARRIES = 0.05  # share of an object's weight from which on another one supports it
_STACKED_SHARE = 1 / 3  # of all objects stand on another one, at least
_ATTEMPTS = 50


def simulate_scene(preset: str, seed: int, index: int) -> tuple[Frame, Truth]:
    """Scene number `index` of a preset; the same to the bit whenever it is made on the same machine.

    Args:
        preset: a key of `PRESETS`.
        seed: not negative; together with `index` it decides everything.

    Returns:
        The image, and the truth about it. In the label image 1 is the table, 2 and up are the objects, then
        come floor and wall. What carries 5 % of an object's weight or more by contact, friction included,
        supports it.

    Raises:
        ValueError: the preset is not known, or a number is negative.
        ModuleNotFoundError: MuJoCo is not installed.
    """
    arrange = _arrangement(preset)
    if seed < 0 or index < 0:
        raise ValueError(f"Seed and index must not be negative, but are {seed} and {index}.")
    entropy = np.random.SeedSequence((seed, index)).generate_state(1, np.uint64)
    generator = torch.Generator().manual_seed(int(entropy[0]))
    with _one_thread():
        pile, carried = _resting_pile(arrange, generator)
        view = draw_view(generator, pile)
        frame = photograph(f"{preset}_{index:04d}", pile, view, generator)
        return frame, _truth(pile, carried, view, frame)


def write_simulated(out: Path, preset: str, count: int, seed: int, jobs: int = 1) -> list[Path]:
    """Write scenes 0 to `count - 1` of a preset as scene folders `out/<preset>_<index>`.

    Scenes that an earlier run with the same seed and version has written are kept, so a run that was
    stopped goes on where it was.

    Args:
        jobs: processes; the scenes do not depend on it.

    Returns:
        The folders, in order.

    Raises:
        ValueError: the preset is not known, a number is out of range, or a folder to be written exists and is
            no simulated scene.
        ModuleNotFoundError: MuJoCo is not installed.
    """
    _arrangement(preset)
    require_mujoco()
    if count < 1 or seed < 0 or jobs < 1:
        raise ValueError(
            f"Needed are one scene or more, a seed from 0 up and one job or more, "
            f"but count is {count}, seed {seed} and jobs {jobs}."
        )
    folders = [Path(out) / f"{preset}_{index:04d}" for index in range(count)]
    todo = [i for i, folder in enumerate(folders) if not _is_made(folder, _origin(preset, seed, i))]
    with Progress(console=Console(stderr=True)) as progress:
        task = progress.add_task("simulating", total=count, completed=count - len(todo))
        made = Parallel(n_jobs=jobs, return_as="generator_unordered")(
            delayed(_write_one)(folders[i], preset, seed, i) for i in todo
        )
        for _ in made:
            progress.advance(task)
    return folders


def _write_one(folder: Path, preset: str, seed: int, index: int) -> None:
    frame, truth = simulate_scene(preset, seed, index)
    write_scene(folder, frame, truth, {"simulation": _origin(preset, seed, index)})


def _arrangement(preset: str) -> Arrangement:
    if preset not in PRESETS:
        raise ValueError(f"There is no preset {preset!r}; choose from: {', '.join(sorted(PRESETS))}.")
    return PRESETS[preset]


def _origin(preset: str, seed: int, index: int) -> dict[str, Any]:
    versions = {name: version(name) for name in ("blockstab", "mujoco")}
    return {"preset": preset, "seed": seed, "index": index, "recipe": RECIPE, "versions": versions}


def _is_made(folder: Path, origin: dict[str, Any]) -> bool:
    if not folder.exists():
        return False
    try:
        found = json.loads((folder / META).read_text())["simulation"]
    except (OSError, ValueError, KeyError, TypeError):
        raise ValueError(f"{folder} exists and is no simulated scene; move it or write elsewhere.") from None
    return bool(found == origin) and all((folder / name).is_file() for name in IMAGES)


def _resting_pile(arrange: Arrangement, generator: torch.Generator) -> tuple[Boxes, Tensor]:
    """A pile at rest, and who carries whom in it, (N + 1, N) bool with the table last."""
    for _ in range(_ATTEMPTS):
        pile = settle(arrange(generator))
        if pile is None:
            continue
        carried = carried_share(pile) >= _CARRIES
        stacked = carried[:-1].any(dim=0).to(torch.float64).mean()
        if float(stacked) >= _STACKED_SHARE and bool(carried.any(dim=0).all()):
            return pile, carried
    raise RuntimeError(f"None of {_ATTEMPTS} arrangements came to rest with a third of it stacked.")


def _truth(pile: Boxes, carried: Tensor, view: View, frame: Frame) -> Truth:
    fallen = falls(pile)
    seen = view.in_camera(pile)
    objects = []
    for i in range(len(pile)):
        pose = torch.eye(4, dtype=torch.float64)
        pose[:3, :3], pose[:3, 3] = seen.rotation[i], seen.center[i]
        # The table's row is the last, and its id is the lowest.
        supporters = carried[:, i].roll(1).nonzero().flatten() + TABLE
        falling = fallen[i].nonzero().flatten() + TABLE + 1
        objects.append(
            ObjectTruth(
                i + TABLE + 1,
                "box",
                pile.half_extent[i],
                pose,
                tuple(supporters.tolist()),
                tuple(falling.tolist()),
            )
        )
    return Truth(frame.background_ids, tuple(objects), frame.up_camera, True)


@contextmanager
def _one_thread() -> Iterator[None]:
    # Sums may depend on how many threads share them, and scenes must not depend on the number of jobs.
    threads = torch.get_num_threads()
    torch.set_num_threads(1)
    try:
        yield
    finally:
        torch.set_num_threads(threads)
