"""`blockstab simulate`: scenes, or verdicts on boxes that were let go, and what is said of them."""

from __future__ import annotations

import time
from pathlib import Path

import typer

from blockstab.commands.parse import stop
from blockstab.simulation.census import census_of
from blockstab.simulation.physics.verdicts import summary, write_verdicts
from blockstab.simulation.simulated import Recipe
from blockstab.simulation.writing import SHEET, write_simulated
from models.entry import one_line_errors


def simulate_scenes(out: Path, recipe: tuple[str, int, str, float], count: int, jobs: int) -> None:
    """Make scenes; `recipe` has the preset, seed, sensor and variety of `Recipe`."""
    begin = time.perf_counter()
    with one_line_errors(stop, str(out)):
        folders = write_simulated(out, Recipe(*recipe), count, jobs)
        said = f"{len(folders)} scenes in {out}; look at {out / SHEET}. {census_of(folders).summary()}"
    typer.echo(f"{said}. {time.perf_counter() - begin:.0f} s")


def simulate_verdicts(out: Path, preset: str, count: int, seed: int, jobs: int) -> None:
    """Let boxes go."""
    begin = time.perf_counter()
    with one_line_errors(stop, str(out)):
        if preset != "blocks":
            raise ValueError(f"Verdicts are about blocks, not {preset}; leave --preset out.")
        files = write_verdicts(out, count, seed, jobs)
        said = f"{len(files)} arrangements in {out}. {summary(files)}"
    typer.echo(f"{said}. {time.perf_counter() - begin:.0f} s")
