"""The README runs, and is as short as it says."""

from __future__ import annotations

import re
from typing import Any

from blockstab.testing.photographs import BLOCKS, photograph
from tests.docs.pages import ROOT, blocks, composed
from tests.synthetic import write_folder

PAGE = ROOT / "README.md"


def test_the_python_of_the_readme_parses_an_image(tmp_path, monkeypatch, capsys):
    write_folder(photograph(*BLOCKS).frame, tmp_path / "my_scene")
    monkeypatch.chdir(tmp_path)
    (code,) = blocks(PAGE, "python")
    assert len([line for line in code.splitlines() if line]) == 12
    names: dict[str, Any] = {}
    exec(compile(code, str(PAGE), "exec", dont_inherit=True), names)
    printed = capsys.readouterr().out.splitlines()
    assert len(printed) == len(names["parsed"].ids)
    assert all("would take along" in line for line in printed)


def test_the_programs_that_the_readme_runs_take_what_it_gives_them():
    found = re.findall(r"`python (train|evaluate)\.py (.*?)`", PAGE.read_text())
    assert {program for program, _ in found} == {"train", "evaluate"}
    for program, words in found:
        composed(program, words.split())


def test_every_target_of_make_that_the_readme_names_exists():
    targets = re.findall(r"^    make (\w+)", PAGE.read_text(), re.MULTILINE)
    assert targets
    for target in targets:
        assert re.search(rf"^{target}:", (ROOT / "Makefile").read_text(), re.MULTILINE)
