"""When machine code on disk is still that of these sources."""

from __future__ import annotations

import shutil

import pytest

from blockstab.boxes.compiled import fits
from blockstab.determinism import machine_code
from blockstab.determinism.machine_code import fingerprint_of
from blockstab.features.compiled import members, nearness, outlines
from blockstab.stability.compiled import islands


@pytest.mark.parametrize(
    "file", ["geometry/polygons.py", "stability/balance.py", "stability/compiled/polygons.py"]
)
def test_a_change_of_any_file_of_its_rooms_gives_another_number(file, tmp_path, monkeypatch):
    shutil.copytree(machine_code._PACKAGE, tmp_path / "package", ignore=shutil.ignore_patterns("__pycache__"))
    monkeypatch.setattr(machine_code, "_PACKAGE", tmp_path / "package")
    before, of_boxes = fingerprint_of("geometry", "stability"), fingerprint_of("boxes")
    with (tmp_path / "package" / file).open("a") as source:
        source.write("\n")
    assert fingerprint_of("geometry", "stability") != before
    assert fingerprint_of("boxes") == of_boxes


@pytest.mark.parametrize("module", [fits, islands, members, nearness, outlines])
def test_the_number_is_part_of_what_machine_code_is_known_by(module):
    def keys(number: int) -> list[object]:
        made = module._kept_while(number)
        functions = made if isinstance(made, tuple) else (made,)
        return [f._cache._index_key((), f.targetctx.codegen()) for f in functions]

    assert all(one != other for one, other in zip(keys(1), keys(2), strict=True))
