"""Many images, in turn or side by side: bad ones are reported, finished ones are not done again."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

import torch
from joblib import Parallel, delayed
from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

from blockstab import __version__
from blockstab.export import write_parsed, write_whole
from blockstab.parser import Parser
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
    """What became of a job: `error` is None, or one line that says what was wrong."""

    name: str
    error: str | None


def parse_all(
    jobs: Sequence[Job], parser: Parser, settings: str, out: Path, workers: int = 1, report: bool = True
) -> list[Outcome]:
    """Parse every image into its folder under `out`, with a progress bar.

    A job whose result is there, made by this version with the same settings from the same files, is not done
    again. Each image has one thread of one worker, so that the result does not depend on how many there are.

    Args:
        settings: all that decides the result beside the image, in words.
        report: write report.html too.

    Raises:
        ValueError: if two jobs have one name.
    """
    names = [job.name for job in jobs]
    twice = next((name for name in names if names.count(name) > 1), None)
    if twice is not None:
        raise ValueError(
            f"Each scene needs a name of its own, but {names.count(twice)} are called {twice}; "
            "parse them to different folders."
        )
    tasks = (delayed(_parse_one)(job, parser, settings, out / job.name, report) for job in jobs)
    outcomes = Parallel(n_jobs=workers, return_as="generator_unordered")(tasks)
    done = list(followed(outcomes, len(jobs), "parsing"))
    return sorted(done, key=lambda outcome: names.index(outcome.name))


def followed(outcomes: Iterable[Outcome], total: int, doing: str) -> Iterable[Outcome]:
    """Pass outcomes on, with a bar on standard error and a line for each that failed."""
    console = Console(stderr=True)
    columns = TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn()
    with Progress(*columns, console=console) as bar:
        task = bar.add_task(doing, total=total)
        for outcome in outcomes:
            if outcome.error is not None:
                console.print(outcome.error, style="red", markup=False, highlight=False, soft_wrap=True)
            bar.advance(task)
            yield outcome


def _parse_one(job: Job, parser: Parser, settings: str, folder: Path, report: bool) -> Outcome:
    torch.set_num_threads(1)
    try:
        made = json.dumps(
            {"version": __version__, "settings": settings, "inputs": job.stamp(), "report": report}
        )
        stamp = folder / MADE
        files = ("labels.png", "scene.json", *(["report.html"] if report else []))
        whole = all((folder / file).is_file() for file in files)
        if whole and stamp.is_file() and stamp.read_text() == made:
            return Outcome(job.name, None)
        parsed = parser(job.read())
        stamp.unlink(missing_ok=True)
        write_parsed(parsed, folder, report)
        write_whole(stamp, made.encode())
    except ValueError as error:
        return Outcome(job.name, _named(job.name, error))
    except OSError as error:
        return Outcome(job.name, f"{job.name}: {error.filename or folder}: {error.strerror or error}.")
    return Outcome(job.name, None)


def _named(name: str, error: ValueError) -> str:
    text = " ".join(str(error).split())
    return text if name in text else f"{name}: {text}"
