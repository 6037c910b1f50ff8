"""Readable scenes of a set: damaged ones are reported, and the run goes on."""

from __future__ import annotations

from collections.abc import Sequence

from joblib import delayed
from rich.console import Console
from rich.progress import track

from blockstab.datasets.sets import SceneSet
from blockstab.executors import each_done


def readable(data: SceneSet, scenes: Sequence[str], strict: bool = False, jobs: int = 1) -> list[str]:
    """Read every scene once, and name those that can be.

    Args:
        strict: stop at the first damaged scene; else each gets a line on standard error, and is left out.
        jobs: scenes read side by side.

    Raises:
        ValueError: a scene is damaged and `strict`, or all are.
    """
    console = Console(stderr=True)
    faults = each_done((delayed(_fault)(data, scene) for scene in scenes), jobs)
    good = []
    for scene, fault in zip(scenes, track(faults, "reading", len(scenes), console=console), strict=True):
        if fault is None:
            good.append(scene)
        elif strict:
            raise ValueError(fault)
        else:
            console.print(f"left out: {fault}", style="red", markup=False, highlight=False, soft_wrap=True)
    if not good:
        raise ValueError(f"None of the {len(scenes)} scenes of {data.name} can be read.")
    return good


def _fault(data: SceneSet, scene: str) -> str | None:
    try:
        data.read(scene)
    except (ValueError, OSError) as error:
        return " ".join(str(error).split())
    return None
