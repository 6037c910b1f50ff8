"""The harness finds what is wrong with a reader, and goes on behind it."""

from __future__ import annotations

import struct
import sys
import zlib
from pathlib import Path

import numpy as np
import pytest
import scipy.io

from tests.fuzzing.cases import Instead, damage, draw_case, pristine, repair
from tests.fuzzing.faulty import FAULTY, SOUND
from tests.fuzzing.harness import fuzz
from tests.fuzzing.mutations import ANY_FILE, Mutation
from tests.fuzzing.structured import mat_element, mutations_for, png_chunks, png_file, png_header

linux = pytest.mark.skipif(sys.platform != "linux", reason="memory is measured in /proc")
PATIENCE = {"waits": 0.5}  # seconds; else long, as a busy machine may let a child wait
FILES = {"a.json": SOUND, "b/c.txt": b"FIELDS x y z\nWIDTH 40\n", "empty": b""}


@linux
@pytest.mark.parametrize(
    ("fault", "verdict"),
    [
        ("raises KeyError", "raised KeyError"),
        ("raises a kind of ValueError", "raised UnicodeDecodeError"),
        ("says two lines", "no clear line"),
        ("waits", "hung"),
        ("works", "took too long"),
        ("aborts", "died"),
        ("takes memory", "took too much"),
        ("reserves memory", "took too much"),
        ("leaves the root", "left the root"),
    ],
)
def test_a_faulty_reader_is_found_out_and_the_next_case_is_run(fault: str, verdict: str) -> None:
    outcomes = list(fuzz(FAULTY[fault], seed=1, numbers=range(2), patience=PATIENCE.get(fault, 30.0)))
    assert [outcome.verdict for outcome in outcomes] == [verdict, verdict]
    assert not any(outcome.sound for outcome in outcomes)


@linux
def test_a_reader_that_refuses_is_sound_and_its_damage_is_named() -> None:
    for number, outcome in enumerate(fuzz(FAULTY["refuses"], seed=1, numbers=range(50), patience=30.0)):
        assert outcome.sound
        assert (outcome.verdict == "refused") == outcome.message.endswith("a.json: is damaged")
        assert outcome.what == draw_case({"a.json": SOUND}, 1, number).what


@linux
def test_a_sound_set_that_is_not_read_stops_the_run() -> None:
    unreadable = FAULTY["refuses"].__class__("none", _write_nothing, FAULTY["refuses"].read)
    with pytest.raises(RuntimeError, match="the sound set of none cannot be read: refused"):
        next(fuzz(unreadable, seed=1, numbers=[0], patience=30.0))


def _write_nothing(root: Path) -> None:
    pass


def test_seed_and_number_repeat_a_case_and_another_number_gives_another() -> None:
    cases = [draw_case(FILES, 3, number) for number in range(40)]
    assert cases == [draw_case(FILES, 3, number) for number in range(40)]
    assert len({str(case) for case in cases}) > 30
    assert cases != [draw_case(FILES, 4, number) for number in range(40)]


def test_damage_touches_only_its_file_and_repair_leaves_the_sound_set(tmp_path: Path) -> None:
    root, outside = tmp_path / "set", tmp_path / "outside"
    for folder in (root, outside):
        for name, content in FILES.items():
            (folder / name).parent.mkdir(parents=True, exist_ok=True)
            (folder / name).write_bytes(content)
    kinds = set()
    for number in range(300):
        case = draw_case(FILES, 1, number)
        damage(root, case, outside)
        kinds |= {change for change in case.changes.values() if isinstance(change, Instead)}
        untouched = {name: content for name, content in FILES.items() if name not in case.changes}
        assert untouched.items() <= pristine(root).items()
        repair(root, case, FILES)
        assert pristine(root) == FILES
    assert kinds == set(Instead)


@pytest.mark.parametrize("mutation", ANY_FILE)
@pytest.mark.parametrize("data", [SOUND * 5, b"", b"x"])
def test_every_mutation_changes_most_files_and_survives_tiny_ones(mutation: Mutation, data: bytes) -> None:
    changed = [mutation(data, np.random.default_rng(seed)) != data for seed in range(30)]
    assert sum(changed) > 15 or len(data) < 2


def test_a_png_keeps_its_checksums_when_its_header_changes() -> None:
    whole = png_file([(b"IHDR", bytes(13)), (b"IDAT", b"pixels"), (b"IEND", b"")])
    assert png_file(png_chunks(whole)) == whole
    assert png_header in mutations_for(whole)
    changed = [png_header(whole, np.random.default_rng(seed)) for seed in range(20)]
    assert all(png_file(png_chunks(data)) == data for data in changed)
    assert len(set(changed)) > 5


def test_a_compressed_element_of_a_matlab_file_can_be_unpacked_after_its_damage(tmp_path: Path) -> None:
    scipy.io.savemat(tmp_path / "a.mat", {"a": np.arange(50.0), "b": "text"}, do_compression=True)
    whole = (tmp_path / "a.mat").read_bytes()
    assert mat_element in mutations_for(whole)
    changed = {mat_element(whole, np.random.default_rng(seed)) for seed in range(20)}
    assert len(changed) > 10
    for data in changed:
        kind, size = struct.unpack_from("<II", data, 128)
        assert kind == 15
        zlib.decompress(data[136 : 136 + size])
