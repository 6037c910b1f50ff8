"""The command line: `blockstab parse`, `blockstab simulate`."""

from __future__ import annotations

import math
import time
from enum import StrEnum
from functools import partial
from pathlib import Path
from typing import Annotated

import typer

from blockstab.boundaries.combination import Combination, FixedWeights
from blockstab.datasets.folder import IMAGES, META
from blockstab.determinism.sources import stamp_of_files
from blockstab.observation import estimated_ground, given_ground
from blockstab.output.batch import Job, parse_all
from blockstab.parsing.parser import NamedPotentials, Parser
from blockstab.proposals import Proposal
from blockstab.proposals.felzenszwalb import Felzenszwalb
from blockstab.proposals.files import SCENE, LabelFile, MaskFile
from blockstab.proposals.plane_pieces import Planes
from blockstab.proposals.watershed import Watershed
from blockstab.rgbd.frame import Camera, read_images, read_scene
from blockstab.search import Search
from blockstab.search.greedy import Greedy
from blockstab.search.rsamp import RSamp
from blockstab.search.start import Start

app = typer.Typer(
    help="Understand RGB-D images as things that stand.",
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    add_completion=False,
)


class ProposalName(StrEnum):
    """Values of --proposals."""

    watershed = "watershed"
    felzenszwalb = "felzenszwalb"
    planes = "planes"
    silberman = "silberman"
    labels = "labels"
    files = "files"


class BoundaryName(StrEnum):
    """Values of --boundaries."""

    fixed = "fixed"
    learned = "learned"


class SearchName(StrEnum):
    """Values of --search."""

    rsamp = "rsamp"
    greedy = "greedy"
    none = "none"


class UpName(StrEnum):
    """Values of --up."""

    estimate = "estimate"
    meta = "meta"


PROPOSALS: dict[ProposalName, type[Proposal]] = {
    ProposalName.watershed: Watershed,
    ProposalName.felzenszwalb: Felzenszwalb,
    ProposalName.planes: Planes,
    ProposalName.labels: LabelFile,
}
SEARCHES: dict[SearchName, type[Search]] = {
    SearchName.rsamp: RSamp,
    SearchName.greedy: Greedy,
    SearchName.none: Start,
}


@app.command()
def parse(
    scenes: Annotated[list[Path] | None, typer.Argument(help="Scene folders.")] = None,
    out: Annotated[Path, typer.Option(help="Where the results go, a folder for each scene.")] = Path("out"),
    color: Annotated[Path | None, typer.Option(help="A colour image, instead of scene folders.")] = None,
    depth: Annotated[Path | None, typer.Option(help="Its depth: 16-bit PNG, millimetres.")] = None,
    fx: Annotated[float, typer.Option(help="Focal length, pixels.")] = math.nan,
    fy: Annotated[float, typer.Option(help="Focal length, pixels.")] = math.nan,
    cx: Annotated[float, typer.Option(help="Principal point, pixels.")] = math.nan,
    cy: Annotated[float, typer.Option(help="Principal point, pixels.")] = math.nan,
    proposals: Annotated[ProposalName, typer.Option(help="First segmentation.")] = ProposalName.watershed,
    masks: Annotated[
        str | None, typer.Option(help="For files: their path, with {scene} for the scene's name.")
    ] = None,
    boundaries: Annotated[
        BoundaryName, typer.Option(help="How cues of an edge are weighed.")
    ] = BoundaryName.fixed,
    search: Annotated[SearchName, typer.Option(help="How it is improved.")] = SearchName.rsamp,
    potentials: Annotated[str, typer.Option(help="trees, mlp, svm, or a file of your own.")] = "trees",
    up: Annotated[UpName, typer.Option(help="Where the up direction comes from.")] = UpName.estimate,
    jobs: Annotated[int, typer.Option(min=1, help="Images parsed side by side.")] = 1,
    seed: Annotated[int, typer.Option(min=0, help="Of the search.")] = 0,
    overwrite: Annotated[bool, typer.Option("--overwrite", help="Parse anew what is there already.")] = False,
) -> None:
    """Parse RGB-D images: segments, boxes, supports, stability, and a report to look at."""
    work = [folder_job(folder) for folder in scenes or []]
    if color is not None or depth is not None:
        work.append(_loose_job(color, depth, Camera(fx, fy, cx, cy)))
    if not work:
        raise typer.BadParameter("give scene folders, or --color and --depth with --fx --fy --cx --cy")
    try:
        proposal = _proposal(proposals, masks)
        if isinstance(proposal, MaskFile):
            _check_masks(work, proposal)
        parser = Parser(
            proposal=proposal,
            search=SEARCHES[search](),
            potentials=_potentials(potentials),
            boundaries=_combination(boundaries),
            ground_of=estimated_ground if up is UpName.estimate else given_ground,
            seed=seed,
        )
        outcomes = parse_all(work, parser, out, workers=jobs, overwrite=overwrite)
    except ValueError as error:
        _stop(str(error))
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
    try:
        if verdicts:
            made = _simulated_verdicts(out, preset, count, seed, jobs)
        else:
            made = _simulated_scenes(out, preset, count, seed, sensor, variety, jobs)
    except (ValueError, ModuleNotFoundError) as error:
        _stop(str(error))
    except OSError as error:
        _stop(
            f"{error.filename or out}: {error.strerror or error}; once that is mended, the same command goes on "
            "where it stopped."
        )
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


def _proposal(name: ProposalName, masks: str | None) -> Proposal:
    if (masks is not None) != (name is ProposalName.files):
        raise typer.BadParameter("--proposals files and --masks belong together")
    if name is ProposalName.silberman:
        from models.stages.stages import silberman

        return silberman()
    return PROPOSALS[name]() if masks is None else MaskFile(masks)


def _check_masks(jobs: list[Job], proposal: MaskFile) -> None:
    if len(jobs) > 1 and SCENE not in str(proposal.path):
        raise typer.BadParameter(f"--masks needs {SCENE} in its path, for each scene has masks of its own")


def _combination(name: BoundaryName) -> Combination:
    if name is BoundaryName.fixed:
        return FixedWeights()
    from models.boundary.training import load_boundary

    return load_boundary()


def _potentials(name: str) -> NamedPotentials:
    from models.potentials.parsing import parsing_potentials

    return parsing_potentials(name)


def _stop(message: str) -> None:
    typer.secho(" ".join(message.split()), fg="red", err=True)
    raise typer.Exit(1)
