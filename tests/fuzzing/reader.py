"""What is fuzzed: something that reads a folder, and a small sound folder for it to read."""

from __future__ import annotations

import os
import sys
import traceback
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from blockstab.rgbd.reading import FrameError
from models.potentials.record import CheckpointError

LONGEST_MESSAGE = 1000  # characters
_REFUSALS = (ValueError, FrameError, CheckpointError)
# What Python itself may open: modules, when they are first needed.
_OF_PYTHON = (sys.prefix, sys.base_prefix, Path(__file__).resolve().parents[2])


@dataclass(frozen=True)
class Reader:
    """A reader of files.

    Args:
        name: of the reader.
        write: makes a small sound set in an empty folder.
        read: reads all of it.
        confined: whether links out of the folder must be refused; paths out of it always must.
    """

    name: str
    write: Callable[[Path], None]
    read: Callable[[Path], None]
    confined: bool = True


def judged(reader: Reader, root: Path) -> tuple[str, str]:
    """Read, and tell what came out: `read`, `refused` or the name of a fault, and the message.

    Only ValueError and the project's own kinds of it may come out, with a message of one line; no file may
    be opened that lies outside the root.
    """
    opened: list[str] = []
    try:
        with _recorded(opened), warnings.catch_warnings():
            warnings.simplefilter("ignore")  # to show one, Python would open the source
            reader.read(root)
        verdict, message = "read", ""
    except Exception as error:
        verdict, message = _refusal(error)
    outside = [path for path in opened if not _within(path, root, reader.confined)]
    return ("left the root", f"opened {outside[0]}") if outside else (verdict, message)


def _refusal(error: Exception) -> tuple[str, str]:
    message = str(error)
    if type(error) not in _REFUSALS:
        frames = traceback.extract_tb(error.__traceback__)
        places = " > ".join(f"{Path(f.filename).name}:{f.lineno}" for f in frames[-4:])
        return f"raised {type(error).__name__}", f"{message[:LONGEST_MESSAGE]} at {places}"
    if len(message) > LONGEST_MESSAGE or not message.isprintable():
        return "no clear line", f"{len(message)} characters: {message[:LONGEST_MESSAGE]!r}"
    return "refused", message


_watchers: list[list[str]] = []
_hooked = False


@contextmanager
def _recorded(opened: list[str]) -> Iterator[None]:
    """Put the path of every file that Python opens into `opened`."""
    global _hooked
    if not _hooked:  # such a hook stays for good
        sys.addaudithook(_hear)
        _hooked = True
    _watchers.append(opened)
    try:
        yield
    finally:
        _watchers.remove(opened)


def _hear(event: str, arguments: tuple[object, ...]) -> None:
    if event == "open" and _watchers and isinstance(arguments[0], str | bytes | os.PathLike):
        _watchers[-1].append(os.fsdecode(arguments[0]))


def _within(path: str, root: Path, confined: bool) -> bool:
    real = os.path.realpath(path) if confined else os.path.normpath(Path.cwd() / path)
    own = os.path.realpath(root) if confined else os.path.normpath(root)
    return any(Path(real).is_relative_to(place) for place in (own, *_OF_PYTHON))
