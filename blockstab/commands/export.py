"""`blockstab export`: boxes as worlds of other programs."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

import typer

from blockstab.commands.parse import stop
from blockstab.output.export import write_whole
from blockstab.output.worlds.meshes import glb, ply
from blockstab.output.worlds.robots import mjcf, urdf
from blockstab.stability.arrangement import Arrangement, read_arrangement
from models.entry import one_line_errors

FORMATS: dict[str, Callable[[Arrangement, str], bytes]] = {
    ".xml": lambda asked, name: mjcf(asked, name).encode(),
    ".urdf": lambda asked, name: urdf(asked, name).encode(),
    ".glb": glb,
    ".ply": lambda asked, name: ply(asked).encode(),
}
"""By the ending of a file, what makes its content of boxes and a name."""


def export_file(file: Path, out: Sequence[Path]) -> None:
    """Write the boxes of a file in the formats that the endings of others name.

    Raises:
        typer.Exit: something is wrong, and it was said what.
    """
    with one_line_errors(stop, str(file)):
        for path in out:
            if path.suffix.lower() not in FORMATS:
                raise ValueError(
                    f"{path}: the ending of a file chooses its format, one of {', '.join(FORMATS)}, but it is "
                    f"{path.suffix!r}; name it otherwise."
                )
        asked = read_arrangement(file)
        made = [(path, FORMATS[path.suffix.lower()](asked, path.stem)) for path in out]
        for path, content in made:
            path.parent.mkdir(parents=True, exist_ok=True)
            write_whole(path, content)
    typer.echo(f"{len(asked.boxes)} boxes in {', '.join(map(str, out))}")
