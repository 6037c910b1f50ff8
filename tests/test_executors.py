"""Results do not depend on where they are worked out."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest
import torch
from joblib import delayed

from blockstab.datasets.sets import FolderScenes
from blockstab.executors import each_done, local, on_ray
from blockstab.output.batch import parse_all
from blockstab.parsing.parser import Parser
from blockstab.proposals.files import LabelFile
from blockstab.search.none import NoSearch
from blockstab.testing.photographs import BLOCKS, photograph
from models.gathering import as_tensors, gathered
from tests.models.test_gathering import MAKER
from tests.output.test_batch import job
from tests.synthetic import write_folder
from tests.test_evaluate import evaluated, place, results  # noqa: F401
from tests.toy_potentials import toy_potentials

QUICK = Parser(LabelFile(), NoSearch(), toy_potentials())
SCENES = ("scene0", "scene1")


@pytest.fixture(autouse=True)
def threads() -> Iterator[None]:
    """Work takes one thread; the tests after it get theirs back."""
    before = torch.get_num_threads()
    yield
    torch.set_num_threads(before)


def halved(number: int) -> float:
    if number < 0:
        raise ValueError(f"{number} is below 0.")
    return number / 2


@pytest.mark.parametrize("jobs", [1, 2])
def test_results_come_in_the_order_of_the_calls_or_all_the_same_as_they_come(jobs: int) -> None:
    work = [delayed(halved)(number) for number in range(7)]
    with local():
        assert list(each_done(work, jobs)) == [0.0, 0.5, 1.0, 1.5, 2.0, 2.5, 3.0]
        assert set(each_done(work, jobs, in_order=False)) == {0.0, 0.5, 1.0, 1.5, 2.0, 2.5, 3.0}


def test_workers_of_ray_make_the_same_bytes(tmp_path: Path) -> None:
    pytest.importorskip("ray", reason="the extra `ray` is not installed")
    folders = [
        write_folder(photograph(*BLOCKS[: k + 2], seed=k).frame, tmp_path / "scenes" / name)
        for k, name in enumerate(SCENES)
    ]
    data, made = FolderScenes(tmp_path / "scenes"), {}
    for executor in (local(), on_ray(cpus=2)):
        out = tmp_path / type(executor).__name__ / str(len(made))
        with executor:
            assert [o.error for o in parse_all(list(map(job, folders)), QUICK, out, workers=2)] == [None] * 2
            examples = gathered(data, list(SCENES), MAKER, seed=0, cache=out / "cache", jobs=2)
            with pytest.raises(ValueError, match="-1 is below 0"):
                list(each_done([delayed(halved)(number) for number in (1, -1)], jobs=2))
        made[len(made)] = [(out / name / "labels.png").read_bytes() for name in SCENES], examples
    (labels, rows), (labels_of_ray, rows_of_ray) = made.values()
    assert labels == labels_of_ray
    for one, other in zip(rows, rows_of_ray, strict=True):
        here, there = as_tensors(one), as_tensors(other)
        assert here.keys() == there.keys()
        assert all(torch.equal(here[name], there[name]) for name in here)


def test_an_evaluation_by_workers_of_ray_has_the_same_results(place: Path) -> None:  # noqa: F811
    pytest.importorskip("ray", reason="the extra `ray` is not installed")
    evaluated(place)
    here = results(place)
    evaluated(place, "executor=ray", "executor.cpus=2", "jobs=2", "overwrite=true")
    assert results(place) == here


def test_a_cluster_that_is_not_there_is_said_so(monkeypatch: pytest.MonkeyPatch) -> None:
    ray = pytest.importorskip("ray", reason="the extra `ray` is not installed")

    def refuse(*_: object, **__: object) -> None:
        raise ConnectionError("nobody answers")

    monkeypatch.setattr(ray, "init", refuse)
    with (
        pytest.raises(ValueError, match="no Ray cluster at ray://head:10001: nobody answers"),
        on_ray("ray://head:10001"),
    ):
        pass
