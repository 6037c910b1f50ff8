"""When machine code on disk is still that of these sources."""

from __future__ import annotations

import shutil

import pytest

from blockstab.stability.compiled import islands as islands


@pytest.mark.parametrize(
    "file", ["geometry/polygons.py", "stability/balance.py", "stability/compiled/polygons.py"]
)
def test_a_change_of_any_file_it_comes_from_makes_the_machine_code_anew(file, tmp_path, monkeypatch):
    shutil.copytree(islands._PACKAGE, tmp_path / "package", ignore=shutil.ignore_patterns("__pycache__"))
    monkeypatch.setattr(islands, "_PACKAGE", tmp_path / "package")
    before = islands._fingerprint()
    with (tmp_path / "package" / file).open("a") as source:
        source.write("\n")
    assert islands._fingerprint() != before


def test_the_fingerprint_is_part_of_what_the_machine_code_is_known_by():
    keys = [
        [function._cache._index_key((), function.targetctx.codegen()) for function in islands._kept_while(k)]
        for k in (1, 2)
    ]
    assert all(one != other for one, other in zip(*keys, strict=True))
