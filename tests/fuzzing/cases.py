"""One damaged data set: which of its files is damaged, and how."""

from __future__ import annotations

import shutil
from collections.abc import Mapping
from dataclasses import dataclass
from enum import Enum
from pathlib import Path

import numpy as np

from tests.fuzzing.structured import PNG, mutations_for, png_resized

Files = Mapping[str, bytes]  # content by path below the root


_SIDES = (1, 2, 39, 41, 640, 7999, 8000, 64_000, 10**6, 32 * 10**6, 64 * 10**6, 2**31 - 1)


class Instead(Enum):
    """What there is in place of a file."""

    NOTHING = "missing"
    FOLDER = "a folder"
    LOOP = "a link to itself"
    NOWHERE = "a link to nothing"
    OUTSIDE = "a link out of the root"
    ENDLESS = "a link to /dev/zero"


@dataclass(frozen=True)
class Case:
    """A damaged set.

    Args:
        what: the damage in words.
        changes: what the files that it touches hold, or what is there instead.
    """

    what: str
    changes: Mapping[str, bytes | Instead]


def draw_case(files: Files, seed: int, number: int) -> Case:
    """Case `number` of a seed; the same files give the same case."""
    random = np.random.default_rng([seed, number])
    names = sorted(files)
    name = names[random.integers(len(names))]
    kind = random.integers(12)
    if kind == 0:
        instead = list(Instead)[random.integers(len(Instead))]
        return Case(f"{name}: {instead.value}", {name: instead})
    if kind == 1:
        other = names[random.integers(len(names))]
        return Case(f"{name}: holds {other}", {name: files[other]})
    if kind == 2 and files[name].startswith(PNG):
        return _resized(files, random)
    data, done = files[name], []
    # Damage upon damage now and then, as one fault may hide another.
    for _ in range(1 + int(random.integers(4) == 0)):
        choices = mutations_for(data)
        mutation = choices[random.integers(len(choices))]
        data = mutation(data, random)
        done.append(mutation.__name__)
    return Case(f"{name}: {', '.join(done)}", {name: data})


def _resized(files: Files, random: np.random.Generator) -> Case:
    """Images that agree on a size, so that it is their pixels that must tell."""
    width, height = (int(random.choice(_SIDES)) for _ in range(2))
    images = {n: png_resized(data, width, height) for n, data in files.items() if data.startswith(PNG)}
    return Case(f"all images say {width} x {height}", images)


def pristine(root: Path) -> dict[str, bytes]:
    """The files below `root`."""
    return {
        path.relative_to(root).as_posix(): path.read_bytes()
        for path in sorted(root.rglob("*"))
        if path.is_file()
    }


def damage(root: Path, case: Case, outside: Path) -> None:
    """Bring the case's damage upon the set in `root`; `outside` is a file that is no part of it."""
    for name, change in case.changes.items():
        path = root / name
        path.unlink()
        if isinstance(change, bytes):
            path.write_bytes(change)
        elif change is Instead.FOLDER:
            path.mkdir()
        elif change is not Instead.NOTHING:
            targets = {
                Instead.LOOP: path.name,
                Instead.NOWHERE: "nowhere",
                Instead.OUTSIDE: outside,
                Instead.ENDLESS: "/dev/zero",
            }
            path.symlink_to(targets[change])


def repair(root: Path, case: Case, files: Files) -> None:
    """Undo the damage."""
    for name in case.changes:
        path = root / name
        if path.is_dir() and not path.is_symlink():
            shutil.rmtree(path)
        path.unlink(missing_ok=True)
        path.write_bytes(files[name])
