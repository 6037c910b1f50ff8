"""Sets of scenes that training and evaluation run over: folders on disk, or scenes simulated when first asked for."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

from blockstab.datasets.folder import read_truth, scene_folders
from blockstab.datasets.simulated import write_simulated


class SceneSet(Protocol):
    """A named set of scene folders."""

    @property
    def name(self) -> str: ...

    def folders(self) -> list[Path]: ...


@dataclass(frozen=True)
class FolderScenes:
    """The scene folders right under `root`.

    Args:
        root: the folder.
        annotated: only the scenes whose supports are annotated.
    """

    root: str | Path
    annotated: bool = False

    @property
    def name(self) -> str:
        """The folder's own name, and whether only a part of it counts."""
        return Path(self.root).resolve().name + (" (annotated)" if self.annotated else "")

    def folders(self) -> list[Path]:
        """The folders, in the order of their names.

        Raises:
            ValueError: if there is none.
        """
        found = scene_folders(Path(self.root))
        if self.annotated:
            found = [folder for folder in found if read_truth(folder).support_annotated]
        if not found:
            raise ValueError(f"{self.root} holds no scene folder (one with a meta.json in it).")
        return found


@dataclass(frozen=True)
class SimulatedScenes:
    """Scenes of a preset, made once in a folder of the cache and used again.

    Args:
        preset, count, seed: as in `blockstab simulate`.
        cache: where sets are kept, each in a folder of its own.
        jobs: scenes made side by side; the scenes do not depend on it.
    """

    preset: str = "blocks"
    count: int = 40
    seed: int = 1000
    cache: str | Path = ".cache/simulated"
    jobs: int = 2

    @property
    def name(self) -> str:
        """What the set is made from."""
        return f"{self.preset}_{self.count}_seed{self.seed}"

    def folders(self) -> list[Path]:
        """The folders, made where they are missing."""
        return write_simulated(Path(self.cache) / self.name, self.preset, self.count, self.seed, self.jobs)
