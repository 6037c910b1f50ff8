"""The code that something is made by is told by its sources, wherever they lie."""

from __future__ import annotations

import importlib
import shutil
import sys
from functools import partial
from pathlib import Path
from types import ModuleType

import pytest

from blockstab.determinism import fingerprint as module
from blockstab.determinism.fingerprint import fingerprint
from blockstab.determinism.sources import PACKAGES, own_sources, sources_in
from blockstab.proposals.watershed import Watershed
from tests.every_part import in_another_process

ROOT = Path(__file__).resolve().parents[2]


def test_sources_are_digested_without_being_imported():
    program = (
        "import sys; from blockstab.determinism.sources import own_sources; "
        "print(own_sources(), sys.modules.keys() & {'models', 'torch'})"
    )
    assert in_another_process(program, seed=2).strip() == f"{own_sources()} set()"


@pytest.mark.parametrize(
    "edited", ["blockstab/energy.py", "blockstab/search/moves.py", "models/potentials/examples.py"]
)
def test_a_line_more_in_any_source_gives_another_fingerprint(tmp_path, monkeypatch, edited):
    folders = [tmp_path / name for name in PACKAGES]
    for folder in folders:
        shutil.copytree(ROOT / folder.name, folder, ignore=shutil.ignore_patterns("*.safetensors", "*.json"))
    before = fingerprint(Watershed())
    monkeypatch.setattr(module, "own_sources", lambda: sources_in(folders))
    assert fingerprint(Watershed()) == before
    with (tmp_path / edited).open("a") as file:
        file.write("# a line more\n")
    assert fingerprint(Watershed()) != before


def test_a_source_of_another_name_gives_another_digest(tmp_path):
    (tmp_path / "a.py").write_text("A = 1\n")
    before = sources_in([tmp_path])
    (tmp_path / "a.py").rename(tmp_path / "b.py")
    assert sources_in([tmp_path]) != before


@pytest.fixture
def written(tmp_path, monkeypatch):
    """A package with a plug-in and a module that this imports, and a plug-in in no package."""
    (tmp_path / "packed").mkdir()
    (tmp_path / "packed" / "helper.py").write_text("STEP = 1\n")
    (tmp_path / "packed" / "plug.py").write_text("from packed.helper import STEP\nclass Plug: pass\n")
    (tmp_path / "loose.py").write_text("class Plug: pass\ndef plug(): pass\n")
    monkeypatch.syspath_prepend(str(tmp_path))
    yield tmp_path
    for name in ("packed", "packed.helper", "packed.plug", "loose", "derived"):
        sys.modules.pop(name, None)


def imported(name: str) -> ModuleType:
    importlib.invalidate_caches()
    return importlib.import_module(name)


@pytest.mark.parametrize(
    ("plug", "edited", "counts"),
    [
        ("packed.plug", "packed/plug.py", True),
        ("packed.plug", "packed/helper.py", True),
        ("packed.plug", "loose.py", False),
        ("loose", "loose.py", True),
        ("loose", "packed/plug.py", False),
    ],
)
def test_the_source_of_a_plug_in_counts_and_its_package(written, plug, edited, counts):
    part = imported(plug).Plug()
    before = fingerprint(part)
    with (written / edited).open("a") as file:
        file.write("# a line more\n")
    assert (fingerprint(part) != before) == counts


def test_the_source_of_a_function_counts_and_of_what_a_class_derives_from(written):
    loose = imported("loose")
    (written / "derived.py").write_text("import loose\nclass Derived(loose.Plug): pass\n")
    parts = [loose.plug, partial(loose.plug), imported("derived").Derived()]
    before = [fingerprint(part) for part in parts]
    (written / "loose.py").write_text("class Plug: pass\ndef plug(): return 1\n")
    sys.modules.pop("derived")
    assert all(fingerprint(part) != old for part, old in zip(parts[:2], before, strict=False))
    sys.modules.pop("loose")
    assert fingerprint(imported("derived").Derived()) != before[2]


def test_what_comes_from_no_file_is_refused():
    names: dict[str, type] = {"__name__": "typed_in"}  # type: ignore[dict-item]
    exec("class Typed: pass", names)
    with pytest.raises(ValueError, match="typed_in lies in no file"):
        fingerprint(names["Typed"]())
