"""Readers with one fault each, to see that the harness finds it."""

from __future__ import annotations

import os
import time
from functools import partial
from pathlib import Path

import numpy as np

from blockstab.rgbd.reading import FrameError
from tests.fuzzing.harness import MOST_MIB, MOST_SECONDS
from tests.fuzzing.reader import Reader

SOUND = b'{"sound": 1, "numbers": [1, 2, 3]}'


def _write(root: Path) -> None:
    (root / "a.json").write_bytes(SOUND)


def _read(fault: str, root: Path) -> None:
    """Reads the sound file; its fault shows on a damaged one."""
    file = root / "a.json"
    if not file.is_file() or file.read_bytes() != SOUND:
        _FAULTS[fault](file)


def _key(file: Path) -> None:
    raise KeyError("objects")


def _subclass(file: Path) -> None:
    b"\xff".decode()


def _lines(file: Path) -> None:
    raise FrameError(f"{file}: is\ndamaged")


def _sleep(file: Path) -> None:
    time.sleep(60)


def _work(file: Path) -> None:
    end = time.process_time() + MOST_SECONDS + 0.1
    while time.process_time() < end:
        pass


def _abort(file: Path) -> None:
    os.abort()


def _take(file: Path) -> None:
    np.ones((MOST_MIB + 1, 2**20), dtype=np.uint8)
    raise FrameError(f"{file}: is damaged")


def _reserve(file: Path) -> None:
    np.zeros((MOST_MIB + 1, 2**20), dtype=np.uint8)


def _leave(file: Path) -> None:
    (file.parent.parent / "outside" / "a.json").read_bytes()


def _refuse(file: Path) -> None:
    raise FrameError(f"{file}: is damaged")


_FAULTS = {
    "raises KeyError": _key,
    "raises a kind of ValueError": _subclass,
    "says two lines": _lines,
    "waits": _sleep,
    "works": _work,
    "aborts": _abort,
    "takes memory": _take,
    "reserves memory": _reserve,
    "leaves the root": _leave,
    "refuses": _refuse,
}
FAULTY = {name: Reader(name, _write, partial(_read, name)) for name in _FAULTS}
