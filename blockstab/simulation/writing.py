"""Sets of simulated scenes on disk: made side by side, resumed where a run was stopped."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from joblib import delayed
from rich.console import Console
from rich.progress import Progress

from blockstab.datasets.folder import BOUNDARY, IMAGES, META, write_scene
from blockstab.executors import Work, each_done
from blockstab.output.export import write_whole
from blockstab.simulation.census import CENSUS, census_of
from blockstab.simulation.contact_sheet import contact_sheet
from blockstab.simulation.physics.engine import require_mujoco
from blockstab.simulation.simulated import Recipe, simulate_scene

SHEET = "contact_sheet.png"


def write_simulated(out: Path, recipe: Recipe, count: int, jobs: int = 1) -> list[Path]:
    """Write scenes 0 to `count - 1` of a recipe as scene folders `out/<preset>_<index>`.

    Beside them come `contact_sheet.png`, to look at, and `census.json`, what there is in the set. Scenes that
    an earlier run with the same recipe and version has written are kept, so a run that was stopped goes on
    where it was.

    Args:
        jobs: processes; the scenes do not depend on it.

    Returns:
        The folders, in order.

    Raises:
        ValueError: a number is out of range, or a folder to be written exists and is no simulated scene.
        ModuleNotFoundError: MuJoCo is not installed.
        OSError: the folder cannot be written, or the disk is full.
    """
    require_mujoco()
    check_amounts(count, jobs)
    folders = [Path(out) / recipe.scene(index) for index in range(count)]
    todo = [i for i, folder in enumerate(folders) if not _is_made(folder, recipe.origin(i))]
    Path(out).mkdir(parents=True, exist_ok=True)
    work = [delayed(_write_one)(folders[i], recipe, i) for i in todo]
    run_all(work, jobs, "simulating", count)
    contact_sheet(folders, Path(out) / SHEET)
    write_whole(Path(out) / CENSUS, (json.dumps(census_of(folders).as_json(), indent=1) + "\n").encode())
    return folders


def check_amounts(count: int, jobs: int) -> None:
    """Refuse numbers that make no set.

    Raises:
        ValueError: there is not one scene and one job at least.
    """
    if count < 1 or jobs < 1:
        raise ValueError(
            f"Needed are one scene or more and one job or more, but count is {count} and jobs {jobs}."
        )


def run_all(work: Sequence[Work], jobs: int, doing: str, total: int) -> None:
    """Run delayed calls side by side under a progress bar; of `total` things, all others are done."""
    with Progress(console=Console(stderr=True)) as progress:
        task = progress.add_task(doing, total=total, completed=total - len(work))
        for _ in each_done(work, jobs, in_order=False):
            progress.advance(task)


def _write_one(folder: Path, recipe: Recipe, index: int) -> None:
    frame, truth = simulate_scene(recipe, index)
    write_scene(folder, frame, truth, {"simulation": recipe.origin(index)})


def _is_made(folder: Path, origin: dict[str, Any]) -> bool:
    if not folder.exists():
        return False
    try:
        found = json.loads((folder / META).read_text())["simulation"]
    except (OSError, ValueError, KeyError, TypeError):
        raise ValueError(f"{folder} exists and is no simulated scene; move it or write elsewhere.") from None
    return bool(found == origin) and all((folder / name).is_file() for name in (*IMAGES, BOUNDARY))
