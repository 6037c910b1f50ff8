"""Reads damaged sets in a child process, under a watch: whatever the bytes, it must survive, and soon."""

from __future__ import annotations

import multiprocessing
import resource
import tempfile
import time
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from multiprocessing.connection import Connection
from multiprocessing.process import BaseProcess
from pathlib import Path

from tests.fuzzing.cases import damage, draw_case, pristine, repair
from tests.fuzzing.reader import Reader, judged

MOST_SECONDS = 2.0
MOST_MIB = 2 * 64_000_000 * 8 // 2**20  # twice the float64 depth of the largest image that is allowed
_BACKSTOP = 8 * 2**30  # bytes, so that what takes too much cannot take the machine with it
_START_SECONDS = 60.0
SOUND = ("read", "refused")


@dataclass(frozen=True)
class Outcome:
    """What became of one case.

    Args:
        number: of the case; with the seed it repeats it.
        what: the damage.
        verdict: `read`, `refused`, or a fault.
        message: of what was raised.
        seconds: time that the processor was at it.
        mib: address space taken at most, above that before; 0 where it is below that of an earlier case.
    """

    number: int
    what: str
    verdict: str
    message: str
    seconds: float
    mib: float

    @property
    def sound(self) -> bool:
        """Whether it was read or refused, within the limits."""
        return self.verdict in SOUND


def fuzz(
    reader: Reader, seed: int, numbers: Iterable[int], patience: float = MOST_SECONDS
) -> Iterator[Outcome]:
    """Damage the reader's set in one way after the other, and read it.

    Args:
        patience: seconds after which a read that gives no answer is stopped.
    """
    with tempfile.TemporaryDirectory() as scratch:
        child = None
        try:
            for number in numbers:
                child = child or _Child(reader, seed, Path(scratch))
                outcome = child.outcome(number, patience)
                yield outcome
                if not outcome.sound:
                    child = child.stop()
        finally:
            if child:
                child.stop()


class _Child:
    """A process that reads one case after the other."""

    def __init__(self, reader: Reader, seed: int, scratch: Path) -> None:
        # A server that forks needs not import everything for each child, and has no threads to lose.
        context = multiprocessing.get_context("forkserver")
        context.set_forkserver_preload(["tests.fuzzing.harness", "tests.fuzzing.miniatures"])
        self._pipe, far = context.Pipe()
        place = tempfile.mkdtemp(dir=scratch)
        self._process: BaseProcess = context.Process(target=_serve, args=(reader, seed, Path(place), far))
        self._process.start()
        far.close()
        ready = self._pipe.recv() if self._pipe.poll(_START_SECONDS) else f"no answer in {_START_SECONDS:g} s"
        if ready != "ready":
            self.stop()
            raise RuntimeError(f"the sound set of {reader.name} cannot be read: {ready}")

    def outcome(self, number: int, patience: float) -> Outcome:
        what = None
        try:
            self._pipe.send(number)
            what = self._pipe.recv()
            if not self._pipe.poll(patience):
                return Outcome(number, what, "hung", f"no answer after {patience:g} s", patience, 0.0)
            return self._pipe.recv()
        except (EOFError, ConnectionError):
            self._process.join()
            if what is None:
                raise RuntimeError(f"case {number} cannot be drawn") from None
            return Outcome(number, what, "died", f"exit code {self._process.exitcode}", 0.0, 0.0)

    def stop(self) -> None:
        self._process.kill()
        self._process.join()
        self._pipe.close()


def _serve(reader: Reader, seed: int, place: Path, pipe: Connection) -> None:
    """Answer each number with the damage, then with the outcome."""
    root, outside = place / "set", place / "outside"
    for folder in (root, outside):
        folder.mkdir()
        reader.write(folder)
    files = pristine(root)
    verdict, message = judged(reader, root)  # loads what is imported late
    pipe.send("ready" if verdict == "read" else f"{verdict}: {message}")
    resource.setrlimit(resource.RLIMIT_AS, (int(_mib("VmSize") * 2**20) + _BACKSTOP,) * 2)
    while True:
        number = pipe.recv()
        case = draw_case(files, seed, number)
        damage(root, case, outside)
        pipe.send(case.what)
        pipe.send(_measured(reader, root, number, case.what))
        repair(root, case, files)


def _measured(reader: Reader, root: Path, number: int, what: str) -> Outcome:
    before, highest, start = _mib("VmSize"), _mib("VmPeak"), time.process_time()
    verdict, message = judged(reader, root)
    seconds, peak = time.process_time() - start, _mib("VmPeak")
    mib = peak - before if peak > highest else 0.0
    if verdict in SOUND and mib > MOST_MIB:
        verdict, message = "took too much", f"{mib:.0f} MiB, of {MOST_MIB} allowed"
    elif verdict in SOUND and seconds > MOST_SECONDS:
        verdict, message = "took too long", f"{seconds:.1f} s, of {MOST_SECONDS:g} allowed"
    return Outcome(number, what, verdict, message, seconds, mib)


def _mib(key: str) -> float:
    """A figure of this process's memory."""
    lines = Path("/proc/self/status").read_text().splitlines()
    return next(int(line.split()[1]) / 1024 for line in lines if line.startswith(f"{key}:"))
