"""The command line: `blockstab parse`, `blockstab simulate`."""

from __future__ import annotations

import math
import time
from functools import partial
from pathlib import Path
from typing import Annotated, Any, NoReturn

import typer

from blockstab.datasets.folder import IMAGES, META
from blockstab.determinism.sources import stamp_of_files
from blockstab.output.batch import Job, parse_all
from blockstab.parsing.parser import Parser
from blockstab.proposals.files import SCENE
from blockstab.rgbd.frame import Camera, read_images, read_scene
from blockstab.rgbd.noise import NOISES
from models.entry import one_line_errors

app = typer.Typer(
    help="Understand RGB-D images as things that stand.",
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    add_completion=False,
)


@app.command()
def parse(
    scenes: Annotated[
        list[str] | None, typer.Argument(help="Scene folders; and settings, such as search.rounds=30.")
    ] = None,
    out: Annotated[Path, typer.Option(help="Where the results go, a folder for each scene.")] = Path("out"),
    color: Annotated[Path | None, typer.Option(help="A colour image, instead of scene folders.")] = None,
    depth: Annotated[Path | None, typer.Option(help="Its depth: 16-bit PNG, millimetres.")] = None,
    fx: Annotated[float, typer.Option(help="Focal length, pixels.")] = math.nan,
    fy: Annotated[float, typer.Option(help="Focal length, pixels.")] = math.nan,
    cx: Annotated[float, typer.Option(help="Principal point, pixels.")] = math.nan,
    cy: Annotated[float, typer.Option(help="Principal point, pixels.")] = math.nan,
    sensor: Annotated[
        str, typer.Option(help="Whose depth noise that pair has: kinect, realsense, ideal.")
    ] = "kinect",
    proposals: Annotated[
        str | None, typer.Option(help="First segmentation: watershed, silberman, labels, files, ...")
    ] = None,
    masks: Annotated[
        str | None, typer.Option(help="For files: their path, with {scene} for the scene's name.")
    ] = None,
    edges: Annotated[
        str | None, typer.Option(help="How cues of an edge are weighed: fixed, learned.")
    ] = None,
    search: Annotated[str | None, typer.Option(help="How it is improved: rsamp, greedy, none.")] = None,
    potentials: Annotated[str | None, typer.Option(help="trees, mlp, svm, or a file of your own.")] = None,
    up: Annotated[str | None, typer.Option(help="Where the up direction is from: estimate, meta.")] = None,
    jobs: Annotated[int, typer.Option(min=1, help="Images parsed side by side.")] = 1,
    seed: Annotated[int | None, typer.Option(min=0, help="Of the search.")] = None,
    overwrite: Annotated[bool, typer.Option("--overwrite", help="Parse anew what is there already.")] = False,
    config_dir: Annotated[
        Path | None, typer.Option(help="A folder of your own YAML files, laid out like configs/.")
    ] = None,
) -> None:
    """Parse RGB-D images: segments, boxes, supports, stability, and a report to look at.

    The options are names for what configs/parse.yaml holds; whatever else it holds can be set too, as a setting.
    """
    settings = [word for word in scenes or [] if "=" in word and not Path(word).exists()]
    work = [folder_job(Path(word)) for word in scenes or [] if word not in settings]
    if color is not None or depth is not None:
        if sensor not in NOISES:
            raise typer.BadParameter(f"--sensor is one of {', '.join(NOISES)}, but it is {sensor!r:.80}")
        work.append(_loose_job(color, depth, Camera(fx, fy, cx, cy, NOISES[sensor])))
    if not work:
        raise typer.BadParameter("give scene folders, or --color and --depth with --fx --fy --cx --cy")
    if (masks is not None) != (proposals == "files"):
        raise typer.BadParameter("--proposals files and --masks belong together")
    if masks is not None and len(work) > 1 and SCENE not in masks:
        raise typer.BadParameter(f"--masks needs {SCENE} in its path, for each scene has masks of its own")
    groups = {"proposals": proposals, "edges": edges, "search": search, "ground": up}
    values = {"proposals.path": masks, "potentials": potentials, "seed": seed}
    with one_line_errors(_stop, str(out)):
        parser = _parser(_given(groups), settings, _given(values), config_dir)
        outcomes = parse_all(work, parser, out, workers=jobs, overwrite=overwrite)
    failed = sum(outcome.error is not None for outcome in outcomes)
    typer.echo(f"{len(outcomes) - failed} of {len(outcomes)} scenes parsed; reports: {out}/*/report.html")
    if failed:
        raise typer.Exit(1)


@app.command()
def simulate(
    out: Annotated[Path, typer.Option(help="Folder for the scenes.")],
    preset: Annotated[
        str, typer.Option(help="What kind of scenes: blocks, objects, grocery, desk.")
    ] = "blocks",
    count: Annotated[int, typer.Option(min=1, help="How many.")] = 10,
    seed: Annotated[int, typer.Option(min=0, help="Of the whole set.")] = 0,
    sensor: Annotated[str, typer.Option(help="How depth is measured: kinect, realsense, ideal.")] = "kinect",
    variety: Annotated[float, typer.Option(help="Of colours and light, from 0, plain, to 1.")] = 1.0,
    verdicts: Annotated[
        bool, typer.Option("--verdicts", help="Boxes let go, and which of them move.")
    ] = False,
    jobs: Annotated[int, typer.Option(min=1, help="Scenes made side by side.")] = 1,
) -> None:
    """Make scenes by physics and ray casting, with exact truth."""
    begin = time.perf_counter()
    with one_line_errors(_stop, str(out)):
        if verdicts:
            made = _simulated_verdicts(out, preset, count, seed, jobs)
        else:
            made = _simulated_scenes(out, preset, count, seed, sensor, variety, jobs)
    typer.echo(f"{made}. {time.perf_counter() - begin:.0f} s")


def _simulated_scenes(
    out: Path, preset: str, count: int, seed: int, sensor: str, variety: float, jobs: int
) -> str:
    from blockstab.simulation.census import census_of
    from blockstab.simulation.simulated import Recipe
    from blockstab.simulation.writing import SHEET, write_simulated

    folders = write_simulated(out, Recipe(preset, seed, sensor, variety), count, jobs)
    return f"{len(folders)} scenes in {out}; look at {out / SHEET}. {census_of(folders).summary()}"


def _simulated_verdicts(out: Path, preset: str, count: int, seed: int, jobs: int) -> str:
    from blockstab.simulation.physics.verdicts import summary, write_verdicts

    if preset != "blocks":
        raise ValueError(f"Verdicts are about blocks, not {preset}; leave --preset out.")
    files = write_verdicts(out, count, seed, jobs)
    return f"{len(files)} arrangements in {out}. {summary(files)}"


def main() -> None:
    """Run the command line."""
    app()


def folder_job(folder: Path) -> Job:
    """The job of parsing one scene folder."""
    files = tuple(folder / name for name in (*IMAGES, META))
    return Job(folder.resolve().name, partial(read_scene, folder), partial(stamp_of_files, files))


def _loose_job(color: Path | None, depth: Path | None, camera: Camera) -> Job:
    if color is None or depth is None:
        raise typer.BadParameter("--color and --depth belong together")
    read = partial(read_images, color, depth, camera)
    return Job(color.stem, read, partial(_stamp_with, (color, depth), camera))


def _stamp_with(files: tuple[Path, ...], camera: Camera) -> str:
    return f"{stamp_of_files(files)} {camera}"


def _parser(
    groups: dict[str, Any], settings: list[str], values: dict[str, Any], config_dir: Path | None
) -> Parser:
    # Whatever is learned, and hydra, is loaded by who asks for a parse.
    from models.configured import composed, parser_maker

    chosen = [f"{group}={name}" for group, name in groups.items()]
    with one_line_errors(_refuse):
        cfg = composed("parse", [*chosen, *settings], values, config_dir)
    return parser_maker(cfg)(cfg)


def _given(options: dict[str, Any]) -> dict[str, Any]:
    return {name: value for name, value in options.items() if value is not None}


def _stop(said: str) -> NoReturn:
    typer.secho(said, fg="red", err=True)
    raise typer.Exit(1) from None


def _refuse(said: str) -> NoReturn:
    raise typer.BadParameter(said) from None
