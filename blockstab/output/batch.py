"""Many images, in turn or side by side: bad ones are reported, finished ones are not done again."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import torch
from joblib import delayed
from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

from blockstab.executors import each_done
from blockstab.output.export import write_whole
from blockstab.output.maker import Maker, Parsing
from blockstab.parsing.look import Look
from blockstab.parsing.parser import Parser
from blockstab.rgbd.frame import Frame

MADE = "made.json"  # what a result was made from; written last


@dataclass(frozen=True)
class Job:
    """One image to parse.

    Args:
        name: of the scene, and of its folder in the output.
        read: gives the image.
        stamp: gives a word that changes whenever the files do that the image is read from.
    """

    name: str
    read: Callable[[], Frame]
    stamp: Callable[[], str]


@dataclass(frozen=True)
class Outcome:
    """Outcome of a job: `error` is None, or one line that says what was wrong."""

    name: str
    error: str | None


def parse_all(
    jobs: Sequence[Job],
    parser: Parser,
    out: Path,
    workers: int = 1,
    report: bool = True,
    overwrite: bool = False,
) -> list[Outcome]:
    """Parse every image into its folder under `out`, as `make_all` does; `report`: write report.html too."""
    return make_all(jobs, {out: Parsing(parser, report)}, workers, overwrite)[out]


def make_all(
    jobs: Sequence[Job], makers: Mapping[Path, Maker], workers: int = 1, overwrite: bool = False
) -> dict[Path, list[Outcome]]:
    """Let each maker make its files of every image, in a folder for each image, with a progress bar.

    What is there, made by the same code with the same settings from the same files, is not made again. Each image has
    one thread of one worker, so that the result does not depend on how many there are; makers share one look at it.

    Args:
        makers: by the folder where the folders of their images go.
        overwrite: do every job, whatever is there.

    Returns:
        what became of each job, in their order, for each maker.

    Raises:
        ValueError: if two jobs have one name, or a maker has a part that no `fingerprint` can tell.
    """
    names = [job.name for job in jobs]
    twice = next((name for name in names if names.count(name) > 1), None)
    if twice is not None:
        raise ValueError(
            f"Each scene needs a name of its own, but {names.count(twice)} are called {twice}; "
            "parse them to different folders."
        )
    made_by = {out: maker.fingerprint for out, maker in makers.items()}
    tasks = (delayed(_make_each)(job, makers, made_by, overwrite) for job in jobs)
    outcomes = each_done(tasks, workers, in_order=False)
    done = list(followed(outcomes, len(jobs), "parsing"))
    return {out: sorted((each[out] for each in done), key=lambda o: names.index(o.name)) for out in makers}


def followed(
    outcomes: Iterable[dict[Path, Outcome]], total: int, doing: str
) -> Iterable[dict[Path, Outcome]]:
    """Pass on what became of each image, with a bar on standard error and a line for all that went wrong."""
    console = Console(stderr=True)
    columns = TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn()
    with Progress(*columns, console=console) as bar:
        task = bar.add_task(doing, total=total)
        for each in outcomes:
            for error in dict.fromkeys(outcome.error for outcome in each.values()):
                if error is not None:
                    console.print(error, style="red", markup=False, highlight=False, soft_wrap=True)
            bar.advance(task)
            yield each


def _make_each(
    job: Job, makers: Mapping[Path, Maker], made_by: Mapping[Path, str], overwrite: bool
) -> dict[Path, Outcome]:
    torch.set_num_threads(1)

    @cache
    def look() -> Look:
        return Look(job.read())

    return {
        out: Outcome(job.name, _error_of(job, maker, made_by[out], out / job.name, look, overwrite))
        for out, maker in makers.items()
    }


def _error_of(
    job: Job, maker: Maker, made_by: str, folder: Path, look: Callable[[], Look], overwrite: bool
) -> str | None:
    """Make the files of one image, where they are not there; what was wrong, in one line."""
    try:
        inputs = f"{job.stamp()} {maker.stamp(job.name)}".strip()
        made = json.dumps({"fingerprint": made_by, "inputs": inputs, "files": list(maker.files)})
        stamp = folder / MADE
        whole = all((folder / file).is_file() for file in maker.files)
        if not overwrite and whole and stamp.is_file() and stamp.read_text() == made:
            return None
        seen = look()
        stamp.unlink(missing_ok=True)
        maker(seen, folder)
        write_whole(stamp, made.encode())
    except ValueError as error:
        return _named(job.name, error)
    except OSError as error:
        return f"{job.name}: {error.filename or folder}: {error.strerror or error}."
    return None


def _named(name: str, error: ValueError) -> str:
    text = " ".join(str(error).split())
    return text if name in text else f"{name}: {text}"
