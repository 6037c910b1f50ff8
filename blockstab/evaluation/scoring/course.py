"""Energy and score in the course of a search (paper, Figure 13)."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

from scipy.stats import spearmanr

from blockstab.energy.recording import Recorder
from blockstab.evaluation.scoring.atoms import OverlapOfAtoms
from blockstab.evaluation.scoring.bootstrap import pooled, step
from blockstab.evaluation.scoring.prediction import Score
from blockstab.output.export import write_whole
from blockstab.parsing.look import Look
from blockstab.parsing.parser import Parser
from blockstab.proposals.search_input import SearchInput
from blockstab.search import rank
from blockstab.search.problem import Potentials
from blockstab.segments.segmentation import Segmentation

FILE = "course.json"


@dataclass(frozen=True)
class Course:
    """Course of energy and score in one image; the score is `overlap`.

    Args:
        energy, overlap: of the best after each round, the first guess first.
        visited_energy, visited_overlap: of every segmentation that the search asked about, each once.
    """

    energy: tuple[float, ...]
    overlap: tuple[float, ...]
    visited_energy: tuple[float, ...]
    visited_overlap: tuple[float, ...]

    def correlation(self) -> Score:
        """Spearman's rank correlation of energy and score over all that was visited, -1 at best."""
        told = len(set(self.visited_energy)) > 1 and len(set(self.visited_overlap)) > 1
        if not told:
            return Score(0.0, 0)
        return Score(float(spearmanr(self.visited_energy, self.visited_overlap).statistic), 1)


@dataclass(frozen=True)
class Following:
    """Makes `course.json` of an image: a search with a look over its shoulder.

    Args:
        parser: whose search it is.
        objects: from the name of a scene to the ids that are scored in it.
    """

    parser: Parser
    objects: Callable[[str], Sequence[int]]
    files: tuple[str, ...] = (FILE,)

    @property
    def fingerprint(self) -> str:
        """That of the parser."""
        return self.parser.fingerprint

    def stamp(self, scene: str) -> str:
        """That of the parser."""
        return self.parser.stamp(scene)

    def __call__(self, look: Look, folder: Path) -> None:
        """Search, and write."""
        course = followed_course(self.parser, look, self.objects(look.frame.name))
        folder.mkdir(parents=True, exist_ok=True)
        write_whole(folder / FILE, (json.dumps(asdict(course)) + "\n").encode())


def followed_course(parser: Parser, look: Look, objects: Sequence[int]) -> Course:
    """The course of a parser's search on an image.

    Raises:
        ValueError: if the image has no labels, or no objects.
    """
    label = look.frame.label
    if label is None or not objects:
        raise ValueError(f"{look.frame.name} has no labelled objects; there is nothing to score against.")
    visited: dict[Segmentation, float] = {}

    def recording(potentials: Potentials, search_input: SearchInput) -> Recorder:
        return Recorder(
            parser.energy(potentials, search_input),
            lambda one, rating: visited.setdefault(one.scene.segmentation, rank(rating)),
        )

    problem, found, _ = replace(parser, energy=recording).search_in(look)
    score = OverlapOfAtoms(problem.search_input.atoms, label, objects)
    return Course(
        found.trace, tuple(map(score, found.bests)), tuple(visited.values()), tuple(map(score, visited))
    )


def read_course(folder: Path) -> Course:
    """Read what `Following` wrote."""
    return Course(**{name: tuple(values) for name, values in json.loads((folder / FILE).read_text()).items()})


def mean_course(courses: Sequence[Course], seed: int) -> dict[str, Any]:
    """Means over images after each round, `energy` and `overlap`: `mean`, `low` and `high`, a value a round each.

    A search that ended early stays where it is.

    Convention:
        `low` and `high` bound the change since the first guess, by 95 %, with images drawn for both rounds together:
        that some images are harder than others does not widen the band.
    """
    rounds = max(len(course.energy) for course in courses)
    return {
        name: _curve([_long(getattr(course, name), rounds) for course in courses], seed)
        for name in ("energy", "overlap")
    }


def _long(values: Sequence[float], length: int) -> list[float]:
    return [*values, *[values[-1]] * (length - len(values))]


def _curve(images: Sequence[Sequence[float]], seed: int) -> dict[str, list[float]]:
    curve: dict[str, list[float]] = {"mean": [], "low": [], "high": []}
    rounds = [{str(k): Score(v, 1) for k, v in enumerate(after)} for after in zip(*images, strict=True)]
    first = pooled(list(rounds[0].values()))
    for scores in rounds:
        change = step(rounds[0], scores, seed)
        assert change is not None
        assert first is not None
        for name, value in zip(curve, (change.mean, *change.ci95), strict=True):
            curve[name].append(first + value)
    return curve
