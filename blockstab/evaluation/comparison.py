"""Methods against each other on the scenes of a data set: files first, then rows of a table."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import torch
from joblib import delayed

from blockstab.datasets.sets import SceneSet
from blockstab.determinism.fingerprint import fingerprint
from blockstab.evaluation.scoring import Score, score_scene
from blockstab.evaluation.scoring.course import Following, mean_course, read_course
from blockstab.evaluation.scoring.prediction import object_ids
from blockstab.evaluation.scoring.rows import Scored, rows_of
from blockstab.executors import each_done
from blockstab.output.batch import Job, make_all
from blockstab.output.maker import Maker, Parsing
from blockstab.parsing.parser import Parser
from blockstab.rgbd.frame import Frame


@dataclass(frozen=True)
class Method:
    """A row of a table: how images are understood, and what of that is scored."""

    parser: Parser
    scores: tuple[str, ...] = ()


@dataclass(frozen=True)
class Comparison:
    """Comparison of methods: its data, and its settings.

    Args:
        data, scenes: the images, all of which can be read.
        out: folder of the files that are scored.
        seed: of the bootstrap.
        jobs: images worked on side by side; no result depends on it.
        overwrite: make files anew that are there already.
    """

    data: SceneSet
    scenes: list[str]
    out: Path
    seed: int = 0
    jobs: int = 1
    overwrite: bool = False

    def table(self, methods: Mapping[str, Method]) -> list[dict[str, Any]]:
        """A row for each method: all parse every scene, then their files are scored.

        Raises:
            ValueError: if a method fails on a scene; a score without it would mislead.
        """
        makers = {name: Parsing(method.parser, report=False) for name, method in methods.items()}
        folders = self._make("predictions", makers)
        wanted = {name: (folders[name], method.scores) for name, method in methods.items()}
        tasks = (delayed(scores_of)(self.data, scene, wanted) for scene in self.scenes)
        each = list(zip(self.scenes, each_done(tasks, self.jobs), strict=True))
        return rows_of(
            [
                Scored(
                    name, m.parser.potentials.name, m.scores, {scene: found[name] for scene, found in each}
                )
                for name, m in methods.items()
            ],
            self.seed,
        )

    def courses(self, methods: Mapping[str, Method]) -> list[dict[str, Any]]:
        """A row for each method: how energy and score go in its search, and how they go together.

        Beside scores, a row has a `course` as `mean_course` tells it.

        Raises:
            ValueError: as in `table`.
        """
        objects = partial(objects_of, self.data)
        makers = {name: Following(method.parser, objects) for name, method in methods.items()}
        folders = self._make("courses", makers)
        courses = {name: {s: read_course(folders[name] / s) for s in self.scenes} for name in methods}
        scored = [
            Scored(
                name,
                method.parser.potentials.name,
                ("overlap", "rank_correlation"),
                {
                    scene: {"overlap": Score(course.overlap[-1], 1), "rank_correlation": course.correlation()}
                    for scene, course in courses[name].items()
                },
            )
            for name, method in methods.items()
        ]
        return [
            {**row, "course": mean_course(list(courses[row["method"]].values()), self.seed)}
            for row in rows_of(scored, self.seed)
        ]

    def _make(self, kind: str, makers: Mapping[str, Maker]) -> dict[str, Path]:
        """Let all makers make their files; the folder of each."""
        folders = {name: self.out / kind / name.replace("/", " ") for name in makers}
        reader = fingerprint(type(self.data))
        jobs = [
            Job(s, partial(frame_of, self.data, s), partial(scene_stamp, self.data, s, reader))
            for s in self.scenes
        ]
        by_folder = {folders[name]: maker for name, maker in makers.items()}
        done = make_all(jobs, by_folder, self.jobs, self.overwrite)
        for name, folder in folders.items():
            failed = sum(outcome.error is not None for outcome in done[folder])
            if failed:
                raise ValueError(
                    f"{name}: {failed} of {len(jobs)} scenes failed; a score without them would mislead."
                )
        return folders


def frame_of(data: SceneSet, scene: str) -> Frame:
    """The image of one scene."""
    return data.read(scene)[0]


def objects_of(data: SceneSet, scene: str) -> tuple[int, ...]:
    """The ids of the objects that are scored in one scene; none where it has no labels."""
    frame, truth = data.read(scene)
    return () if frame.label is None else object_ids(frame, truth)


def scene_stamp(data: SceneSet, scene: str, reader: str) -> str:
    """Changes with the files of one scene, and with the code that reads them."""
    return f"{reader} {data.stamp(scene)}"


def scores_of(
    data: SceneSet, scene: str, wanted: Mapping[str, tuple[Path, tuple[str, ...]]]
) -> dict[str, dict[str, Score]]:
    """The scores of each method in one scene, from its folder of predictions."""
    torch.set_num_threads(1)
    frame, truth = data.read(scene)
    return {
        method: score_scene(frame, truth, folder / scene, names) for method, (folder, names) in wanted.items()
    }
