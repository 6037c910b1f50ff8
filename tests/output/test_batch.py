"""Many images: whatever happens to one, the others are done, and nothing is done twice."""

from __future__ import annotations

import json
import shutil
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path

import pytest
import torch

from blockstab import observation as observation
from blockstab.determinism import fingerprint
from blockstab.determinism.sources import stamp_of_files
from blockstab.output import batch, export
from blockstab.output.batch import MADE, Job, Outcome, make_all, parse_all
from blockstab.output.maker import Parsing
from blockstab.parsing.look import Look
from blockstab.parsing.parsed import Parsed
from blockstab.parsing.parser import Parser
from blockstab.proposals.files import LabelFile, MaskFile
from blockstab.proposals.watershed import Watershed
from blockstab.rgbd.frame import read_scene
from blockstab.scene.inference import Rules
from blockstab.search.greedy import Greedy
from blockstab.search.none import NoSearch
from blockstab.search.rsamp import RSamp
from blockstab.stability.judges import EverySupport
from blockstab.testing.photographs import BLOCKS, photograph
from tests.synthetic import write_folder
from tests.toy_potentials import random_potentials, toy_potentials

QUICK = Parser(LabelFile(), NoSearch(), toy_potentials())


def job(folder: Path) -> Job:
    files = tuple(folder / name for name in ("color.png", "depth.png", "label.png", "meta.json"))
    return Job(folder.name, partial(read_scene, folder), partial(stamp_of_files, files))


@pytest.fixture
def folders(tmp_path: Path) -> list[Path]:
    """Two scene folders, of two blocks and of four."""
    return [
        write_folder(photograph(*BLOCKS[: 2 * k + 2], seed=k).frame, tmp_path / "scenes" / f"scene{k}")
        for k in range(2)
    ]


@dataclass
class Counting:
    """A parser that keeps account of what it parsed, and may be told to fail."""

    parser: Parser = QUICK
    parsed: list[str] = field(default_factory=list)
    error: BaseException | None = None

    @property
    def fingerprint(self) -> str:
        return self.parser.fingerprint

    def stamp(self, scene: str) -> str:
        return self.parser.stamp(scene)

    def understand(self, look: Look) -> Parsed:
        self.parsed.append(look.frame.name)
        if self.error is not None:
            raise self.error
        return self.parser.understand(look)


def run(folders: list[Path], out: Path, parser: object = QUICK, **options) -> list[Outcome]:
    return parse_all([job(folder) for folder in folders], parser, out, report=False, **options)


def contents(out: Path) -> dict[str, object]:
    """All files of a result, without the seconds it took."""
    found: dict[str, object] = {}
    for file in sorted(out.rglob("*")):
        if file.name == "scene.json":
            record = json.loads(file.read_text())
            assert record.pop("seconds")
            found[str(file.relative_to(out))] = json.dumps(record)
        elif file.is_file():
            found[str(file.relative_to(out))] = file.read_bytes()
    return found


def test_every_scene_gets_a_folder_of_its_own(folders, tmp_path):
    assert run(folders, tmp_path / "out") == [Outcome("scene0", None), Outcome("scene1", None)]
    assert sorted(contents(tmp_path / "out")) == [
        f"scene{k}/{name}" for k in range(2) for name in ("labels.png", MADE, "scene.json")
    ]


def test_two_workers_write_the_same_bytes_as_one(folders, tmp_path):
    parser = Parser(Watershed(), RSamp(rounds=2), toy_potentials())
    run(folders, tmp_path / "one", parser, workers=1)
    run(folders, tmp_path / "two", parser, workers=2)
    assert len(contents(tmp_path / "one")) == 6
    assert contents(tmp_path / "one") == contents(tmp_path / "two")


def test_a_bad_scene_is_reported_and_the_rest_goes_on(folders, tmp_path, capsys):
    (folders[0] / "depth.png").write_bytes(b"no image")
    bad, good = run(folders, tmp_path / "out")
    assert good == Outcome("scene1", None)
    assert str(folders[0] / "depth.png") in bad.error
    assert "\n" not in bad.error
    assert bad.error in capsys.readouterr().err
    assert not (tmp_path / "out" / "scene0").exists()
    assert (tmp_path / "out" / "scene1" / "scene.json").is_file()


def test_an_error_that_does_not_name_its_scene_is_given_the_name(folders, tmp_path):
    outcomes = run(folders, tmp_path / "out", Counting(error=ValueError("the moon\nis full")))
    assert outcomes[1].error == "scene1: the moon is full"


def test_a_folder_that_cannot_be_written_is_reported(folders, tmp_path):
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "scene0").write_text("in the way")
    blocked, good = run(folders, tmp_path / "out")
    assert blocked.error.startswith(f"scene0: {tmp_path / 'out' / 'scene0'}")
    assert good.error is None


def test_what_is_done_is_not_done_again(folders, tmp_path):
    run(folders[:1], tmp_path / "out")
    counting = Counting()
    assert run(folders, tmp_path / "out", counting) == [Outcome("scene0", None), Outcome("scene1", None)]
    assert counting.parsed == ["scene1"]


@pytest.mark.parametrize(
    "change",
    [{"seed": 2}, {"potentials": random_potentials()}, {"rules": Rules(judge=EverySupport())}],
    ids=["seed", "potentials", "rules"],
)
def test_other_settings_are_done_anew(folders, tmp_path, change):
    run(folders, tmp_path / "out")
    counting = Counting(replace(QUICK, **change))
    run(folders, tmp_path / "out", counting)
    assert counting.parsed == ["scene0", "scene1"]


def test_a_proposals_own_files_are_read_again_when_they_change(folders, tmp_path):
    (tmp_path / "masks").mkdir()
    for folder in folders:
        (tmp_path / "masks" / f"{folder.name}.png").write_bytes((folder / "label.png").read_bytes())
    counting = Counting(replace(QUICK, proposal=MaskFile(f"{tmp_path}/masks/{{scene}}.png")))
    run(folders, tmp_path / "out", counting)
    shutil.copy(tmp_path / "masks" / "scene0.png", tmp_path / "masks" / "scene1.png")
    run(folders, tmp_path / "out", counting)
    assert counting.parsed == ["scene0", "scene1", "scene1"]


def test_told_to_overwrite_it_does_again_what_is_done(folders, tmp_path):
    run(folders, tmp_path / "out")
    counting = Counting()
    run(folders, tmp_path / "out", counting, overwrite=True)
    assert counting.parsed == ["scene0", "scene1"]


@pytest.mark.parametrize("file", ["color.png", "meta.json"])
def test_other_inputs_are_done_anew(folders, tmp_path, file):
    run(folders, tmp_path / "out")
    other = photograph(*BLOCKS, seed=5, noise=0.0).frame
    changed = write_folder(replace(other, color=255 - other.color), tmp_path / "other")
    meta = json.loads((folders[1] / "meta.json").read_text())
    (changed / "meta.json").write_text(json.dumps({**meta, "note": "new"}))
    (folders[1] / file).write_bytes((changed / file).read_bytes())
    counting = Counting()
    run(folders, tmp_path / "out", counting)
    assert counting.parsed == ["scene1"]


def test_other_code_does_it_anew(folders, tmp_path, monkeypatch):
    run(folders[:1], tmp_path / "out")
    monkeypatch.setattr(fingerprint, "own_sources", lambda: "a line more")
    counting = Counting()
    run(folders[:1], tmp_path / "out", counting)
    assert counting.parsed == ["scene0"]


@pytest.mark.parametrize("file", ["labels.png", "scene.json", MADE])
def test_a_result_that_lost_a_file_is_done_anew(folders, tmp_path, file):
    run(folders, tmp_path / "out")
    (tmp_path / "out" / "scene0" / file).unlink()
    counting = Counting()
    run(folders, tmp_path / "out", counting)
    assert counting.parsed == ["scene0"]


def test_a_report_that_was_not_made_is_made(folders, tmp_path):
    run(folders[:1], tmp_path / "out")
    parse_all([job(folders[0])], QUICK, tmp_path / "out")
    assert (tmp_path / "out" / "scene0" / "report.html").is_file()


def test_two_scenes_of_one_name_are_refused(folders, tmp_path):
    with pytest.raises(ValueError, match="2 are called scene0"):
        run([folders[0], folders[1], folders[0]], tmp_path / "out")
    assert not (tmp_path / "out").exists()


def kill_after(writes: int, patch: pytest.MonkeyPatch) -> None:
    """End the run when it comes to write one file more."""
    done: list[Path] = []
    write = export.write_whole

    def until_killed(path: Path, content: bytes) -> None:
        if len(done) == writes:
            raise KeyboardInterrupt
        done.append(path)
        write(path, content)

    patch.setattr(export, "write_whole", until_killed)
    patch.setattr(batch, "write_whole", until_killed)


@pytest.mark.parametrize("writes", [0, 1, 2])
def test_a_killed_run_leaves_no_half_file_and_no_scene_that_looks_finished(
    folders, tmp_path, monkeypatch, writes
):
    run(folders[:1], tmp_path / "whole")
    whole = contents(tmp_path / "whole")
    with monkeypatch.context() as patch:
        kill_after(writes, patch)
        with pytest.raises(KeyboardInterrupt):
            run(folders[:1], tmp_path / "out")
    left = contents(tmp_path / "out")
    assert len(left) == writes
    assert left.items() <= whole.items()
    assert f"scene0/{MADE}" not in left
    counting = Counting()
    run(folders[:1], tmp_path / "out", counting)
    assert counting.parsed == ["scene0"]
    assert contents(tmp_path / "out") == whole


@pytest.mark.parametrize("writes", [1, 2])
def test_a_killed_run_does_not_pass_for_the_one_before_it(folders, tmp_path, monkeypatch, writes):
    run(folders[:1], tmp_path / "out")
    with monkeypatch.context() as patch:
        kill_after(writes, patch)
        with pytest.raises(KeyboardInterrupt):
            run(folders[:1], tmp_path / "out", replace(QUICK, seed=1))
    counting = Counting()
    run(folders[:1], tmp_path / "out", counting)
    assert counting.parsed == ["scene0"]


def test_what_several_parsers_ask_of_an_image_is_computed_once(folders, tmp_path, monkeypatch):
    looked: list[str] = []

    def observe(frame, *settings):
        looked.append(frame.name)
        return observation.observe(frame, *settings)

    monkeypatch.setattr("blockstab.parsing.look.observe", observe)
    trimmed = replace(QUICK, rules=Rules(judge=EverySupport()))
    makers = {tmp_path / name: Parsing(p, report=False) for name, p in (("one", QUICK), ("two", trimmed))}
    make_all([job(folder) for folder in folders], makers)
    assert looked == ["scene0", "scene1"]
    assert contents(tmp_path / "one").keys() == contents(tmp_path / "two").keys()


def test_beside_another_parser_the_same_bytes_are_written(folders, tmp_path):
    greedy = Parser(QUICK.proposal, Greedy(), QUICK.potentials, edges=QUICK.edges)
    run(folders, tmp_path / "alone", greedy)
    makers = {tmp_path / name: Parsing(p, report=False) for name, p in (("first", QUICK), ("beside", greedy))}
    make_all([job(folder) for folder in folders], makers)
    assert contents(tmp_path / "alone") == contents(tmp_path / "beside")


def test_where_one_parser_fails_the_other_goes_on(folders, tmp_path, capsys):
    broken = Counting(error=ValueError("the moon is full"))
    makers = {tmp_path / name: Parsing(p, report=False) for name, p in (("bad", broken), ("good", QUICK))}
    found = make_all([job(folders[0])], makers)
    assert found[tmp_path / "bad"] == [Outcome("scene0", "scene0: the moon is full")]
    assert found[tmp_path / "good"] == [Outcome("scene0", None)]
    assert capsys.readouterr().err.count("the moon is full") == 1


def test_no_scene_is_no_work(tmp_path):
    assert run([], tmp_path / "out") == []


def test_outcomes_come_in_the_order_of_the_jobs(folders, tmp_path):
    assert [outcome.name for outcome in run(folders[::-1], tmp_path / "out")] == ["scene1", "scene0"]


@pytest.fixture(autouse=True)
def threads():
    """A worker takes one thread; the tests after it get theirs back."""
    before = torch.get_num_threads()
    yield
    torch.set_num_threads(before)
