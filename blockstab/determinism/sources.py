"""Digests of the code that makes something: of source files, and of any other files."""

from __future__ import annotations

import hashlib
import sys
from collections.abc import Iterable
from functools import cache
from importlib.util import find_spec
from pathlib import Path

PACKAGES = ("blockstab", "models")  # digested whole


@cache
def own_sources() -> str:
    """The digest of the sources of both packages, as they were when this process first asked."""
    # Found and not imported: what is learned is no concern of most of this package.
    specs = [find_spec(name) for name in PACKAGES]
    return sources_in(
        Path(place) for spec in specs if spec for place in spec.submodule_search_locations or ()
    )


def sources_in(folders: Iterable[Path]) -> str:
    """One digest over all Python files in folders, at any depth, and over their names."""
    files = [
        (f"{folder.name}/{file.relative_to(folder).as_posix()}", file)
        for folder in folders
        for file in folder.rglob("*.py")
    ]
    return hashed(*(part for name, file in sorted(files) for part in (name, file.read_bytes()))).hex()


def source_of(module: str) -> bytes:
    """Version or digest that tells a module's code from another of the same name; empty where nothing does.

    Nothing does for Python's own modules and for those of this project, whose sources count as a whole. For one of an
    installed library it is the library's version; for any other, a digest of its source and, if it belongs to a
    package, of those beside it.

    Raises:
        ValueError: it comes from no file, as what is typed in does.
    """
    top = module.partition(".")[0]
    if top in PACKAGES or top in sys.stdlib_module_names:
        return b""
    loaded, library = sys.modules.get(module), sys.modules.get(top)
    file = getattr(loaded, "__file__", None)
    home = Path(file or getattr(library, "__file__", None) or "")
    if {"site-packages", "dist-packages"} & set(home.parts):
        return str(getattr(library, "__version__", "")).encode()
    if file is None:
        raise ValueError(f"The code of {module} lies in no file to tell it by; write it in a module.")
    packed = "." in module or hasattr(loaded, "__path__")
    files = {Path(file), *(Path(file).parent.glob("*.py") if packed else ())}
    return hashed(*(part for one in sorted(files) for part in (one.name, one.read_bytes())))


def stamp_of_files(files: Iterable[Path]) -> str:
    """One hash over the files that are there; a missing one is reported, by name, where it is read."""
    digest = hashlib.sha256()
    for file in files:
        digest.update(hashlib.sha256(file.read_bytes()).digest() if file.is_file() else b"-")
    return digest.hexdigest()


def hashed(*parts: str | bytes) -> bytes:
    """One SHA-256 over parts, told from each other."""
    digest = hashlib.sha256()
    for part in parts:
        content = part.encode() if isinstance(part, str) else part
        digest.update(b"%d:" % len(content) + content)
    return digest.digest()
