"""`blockstab parse`: from words to jobs and a parser, and what is said of the outcome."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any, NoReturn

import typer

from blockstab.datasets.folder import IMAGES, META
from blockstab.determinism.sources import stamp_of_files
from blockstab.output.batch import Job, parse_all
from blockstab.proposals.files import SCENE
from blockstab.rgbd.frame import Camera, read_images, read_scene
from blockstab.rgbd.noise import NOISES
from models.configured import composed, made, parser_maker
from models.entry import one_line_errors


def parse_scenes(
    words: Sequence[str],
    loose: Job | None,
    groups: Mapping[str, str | None],
    values: Mapping[str, Any],
    out: Path,
    jobs: int,
    overwrite: bool,
    config_dir: Path | None,
) -> None:
    """Parse scenes.

    Args:
        words: scene folders and settings.
        loose: a pair of images.
        groups: the groups of `configs/parse.yaml` and what is chosen of each; None: what stands there.
        values: the same of single values, by their place.

    Raises:
        typer.BadParameter: the options do not go together.
        typer.Exit: something failed, and it was said what.
    """
    settings = [word for word in words if "=" in word and not Path(word).exists()]
    work = [folder_job(Path(word)) for word in words if word not in settings]
    work += [loose] if loose is not None else []
    if not work:
        raise typer.BadParameter("give scene folders, or --color and --depth with --fx --fy --cx --cy")
    masks = values["proposals.path"]
    if (masks is not None) != (groups["proposals"] == "files"):
        raise typer.BadParameter("--proposals files and --masks belong together")
    if masks is not None and len(work) > 1 and SCENE not in masks:
        raise typer.BadParameter(f"--masks needs {SCENE} in its path, for each scene has masks of its own")
    chosen = [f"{group}={name}" for group, name in groups.items() if name is not None]
    given = {place: value for place, value in values.items() if value is not None}
    with one_line_errors(stop, str(out)):
        with one_line_errors(_refuse):
            cfg = composed("parse", [*chosen, *settings], given, config_dir)
        with made(cfg.executor):
            outcomes = parse_all(work, parser_maker(cfg)(cfg), out, workers=jobs, overwrite=overwrite)
    failed = sum(outcome.error is not None for outcome in outcomes)
    typer.echo(f"{len(outcomes) - failed} of {len(outcomes)} scenes parsed; reports: {out}/*/report.html")
    if failed:
        raise typer.Exit(1)


def folder_job(folder: Path) -> Job:
    """The job of parsing one scene folder."""
    files = tuple(folder / name for name in (*IMAGES, META))
    return Job(folder.resolve().name, partial(read_scene, folder), partial(stamp_of_files, files))


def loose_job(
    color: Path | None, depth: Path | None, intrinsics: tuple[float, float, float, float], sensor: str
) -> Job | None:
    """The job of parsing a pair of images; none where none is given.

    Args:
        intrinsics: fx, fy, cx, cy, pixels.
        sensor: whose depth noise it has.
    """
    if color is None and depth is None:
        return None
    if sensor not in NOISES:
        raise typer.BadParameter(f"--sensor is one of {', '.join(NOISES)}, but it is {sensor!r:.80}")
    if color is None or depth is None:
        raise typer.BadParameter("--color and --depth belong together")
    camera = Camera(*intrinsics, NOISES[sensor])
    read = partial(read_images, color, depth, camera)
    return Job(color.stem, read, partial(_stamp_with, (color, depth), camera))


def _stamp_with(files: tuple[Path, ...], camera: Camera) -> str:
    return f"{stamp_of_files(files)} {camera}"


def stop(said: str) -> NoReturn:
    """Print a line on standard error, and leave with status 1."""
    typer.secho(said, fg="red", err=True)
    raise typer.Exit(1) from None


def _refuse(said: str) -> NoReturn:
    raise typer.BadParameter(said) from None
