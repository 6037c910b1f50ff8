"""`blockstab simulate`: scenes, or verdicts on boxes that were let go, and what is said of them."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from pathlib import Path

import typer

from blockstab.commands.parse import stop
from blockstab.datasets.folder import read_truth
from blockstab.simulation.census import census_of
from blockstab.simulation.physics.verdicts import summary, write_verdicts
from blockstab.simulation.simulated import Recipe
from blockstab.simulation.spoilt import spoilt
from blockstab.simulation.writing import SHEET, write_simulated
from models.entry import one_line_errors


def simulate_scenes(
    out: Path, preset: str, count: int, seed: int, sensor: str, variety: float, way: str | None, jobs: int
) -> None:
    """Make scenes; with a way to spoil them, such that do not stand."""

    def made() -> str:
        recipe = Recipe if way is None else spoilt(way)
        folders = write_simulated(out, recipe(preset, seed, sensor, variety), count, jobs)
        said = census_of(folders).summary() if way is None else _moving(folders)
        return f"{len(folders)} scenes in {out}; look at {out / SHEET}. {said}"

    _say(made, out)


def _moving(folders: Sequence[Path]) -> str:
    """How much of spoilt scenes moves; nothing is known of what carries what in them."""
    objects = [o for folder in folders for o in read_truth(folder).objects]
    return f"{sum(bool(o.moves) for o in objects)} of {len(objects)} objects would move"


def simulate_verdicts(out: Path, preset: str, count: int, seed: int, jobs: int) -> None:
    """Let boxes go."""

    def made() -> str:
        if preset != "blocks":
            raise ValueError(f"Verdicts are about blocks, not {preset}; leave --preset out.")
        files = write_verdicts(out, count, seed, jobs)
        return f"{len(files)} arrangements in {out}. {summary(files)}"

    _say(made, out)


def _say(made: Callable[[], str], out: Path) -> None:
    """Print what was made, and in how many seconds; or the mistake."""
    begin = time.perf_counter()
    with one_line_errors(stop, str(out)):
        said = made()
    typer.echo(f"{said}. {time.perf_counter() - begin:.0f} s")
