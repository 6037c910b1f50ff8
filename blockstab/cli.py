"""The command line: `blockstab parse`, `simulate`, `judge`, `export`."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Annotated

import typer

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
    # Who only asks for help does not wait for torch.
    from blockstab.commands.parse import loose_job, parse_scenes

    parse_scenes(
        scenes or [],
        loose_job(color, depth, (fx, fy, cx, cy), sensor),
        {"proposals": proposals, "edges": edges, "search": search, "ground": up},
        {"proposals.path": masks, "potentials": potentials, "seed": seed},
        out,
        jobs,
        overwrite,
        config_dir,
    )


@app.command()
def simulate(
    out: Annotated[Path, typer.Option(help="Folder for the scenes.")],
    preset: Annotated[
        str, typer.Option(help="What kind of scenes: blocks, objects, grocery, desk, room.")
    ] = "blocks",
    count: Annotated[int, typer.Option(min=1, help="How many.")] = 10,
    seed: Annotated[int, typer.Option(min=0, help="Of the whole set.")] = 0,
    sensor: Annotated[str, typer.Option(help="How depth is measured: kinect, realsense, ideal.")] = "kinect",
    variety: Annotated[float, typer.Option(help="Of colours and light, from 0, plain, to 1.")] = 1.0,
    spoilt: Annotated[
        str | None,
        typer.Option(help="Scenes that do not stand: support, of which one was taken out; let_go."),
    ] = None,
    verdicts: Annotated[
        bool, typer.Option("--verdicts", help="Boxes let go, and which of them move.")
    ] = False,
    jobs: Annotated[int, typer.Option(min=1, help="Scenes made side by side.")] = 1,
) -> None:
    """Make scenes by physics and ray casting, with exact truth."""
    from blockstab.commands.simulate import simulate_scenes, simulate_verdicts

    if verdicts:
        simulate_verdicts(out, preset, count, seed, jobs)
    else:
        simulate_scenes(out, preset, count, seed, sensor, variety, spoilt, jobs)


@app.command()
def judge(
    file: Annotated[Path, typer.Argument(help="A scene.json, or a JSON list of boxes.")],
    by: Annotated[
        str, typer.Option(help="Judges: paper, equilibrium, physics, any of them.")
    ] = "paper,equilibrium",
    out: Annotated[Path | None, typer.Option(help="A JSON file for what they say.")] = None,
) -> None:
    """Say of boxes which stand, what falls if one is taken away, and in which order none does."""
    from blockstab.commands.judge import judge_file

    judge_file(file, by, out)


@app.command()
def export(
    file: Annotated[Path, typer.Argument(help="A scene.json, or a JSON list of boxes.")],
    out: Annotated[
        list[Path], typer.Argument(help="Files to write: .xml (MJCF of MuJoCo), .urdf, .glb, .ply.")
    ],
) -> None:
    """Write boxes as worlds of other programs: simulators, planners, viewers."""
    from blockstab.commands.export import export_file

    export_file(file, out)


def main() -> None:
    """Run the command line."""
    app()
