"""Makers of the files of an image: a parse, or anything else of the shape `Maker`."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

from blockstab.output.export import write_parsed
from blockstab.parsing.look import Look
from blockstab.parsing.parser import Parser


class Maker(Protocol):
    """Makes files of an image."""

    @property
    def files(self) -> Sequence[str]:
        """Their names."""

    @property
    def fingerprint(self) -> str:
        """Fingerprint, in one word, of all that decides them beside the image."""

    def stamp(self, scene: str) -> str:
        """A word that changes whenever the files do that are read for a scene beside its image."""

    def __call__(self, look: Look, folder: Path) -> None:
        """Write them, each whole or not at all; `folder` may not be there yet."""


@dataclass(frozen=True)
class Parsing:
    """Makes the files of a parse.

    Args:
        report: report.html too.
    """

    parser: Parser
    report: bool = True

    @property
    def files(self) -> tuple[str, ...]:
        """Their names."""
        return "labels.png", "scene.json", *(["report.html"] if self.report else [])

    @property
    def fingerprint(self) -> str:
        """That of the parser."""
        return self.parser.fingerprint

    def stamp(self, scene: str) -> str:
        """That of the parser."""
        return self.parser.stamp(scene)

    def __call__(self, look: Look, folder: Path) -> None:
        """Parse, and write."""
        write_parsed(self.parser.understand(look), folder, self.report)
