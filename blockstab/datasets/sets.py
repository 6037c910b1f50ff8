"""Sets of labelled scenes, whatever their files look like: what training and evaluation run over."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

from blockstab.datasets.folder import BOUNDARY, IMAGES, META, read_truth, scene_folders
from blockstab.datasets.truth import Truth
from blockstab.determinism.sources import stamp_of_files
from blockstab.rgbd.frame import Frame, read_scene


class SceneSet(Protocol):
    """Labelled scenes of one kind. Each has a name, unlike all others and fit to be a folder's."""

    @property
    def name(self) -> str:
        """Of the set, for results."""

    def scenes(self) -> list[str]:
        """The names of its scenes, in a fixed order; ValueError where there is none."""

    def read(self, scene: str) -> tuple[Frame, Truth]:
        """One scene; FrameError, a line that names the file, where it is damaged."""

    def stamp(self, scene: str) -> str:
        """A word that changes whenever the scene's files do, and with them or the settings what `read` gives."""

    def official(self) -> Mapping[str, Sequence[str]]:
        """The split that came with the set: names of scenes by part; empty where none did."""


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

    def scenes(self) -> list[str]:
        """The names of the folders, sorted.

        Raises:
            ValueError: if there is none.
        """
        found = scene_folders(Path(self.root))
        if self.annotated:
            found = [folder for folder in found if _annotated_or_damaged(folder)]
        if not found:
            raise ValueError(f"{self.root} holds no scene folder (one with a meta.json in it).")
        return [folder.name for folder in found]

    def read(self, scene: str) -> tuple[Frame, Truth]:
        """One scene."""
        folder = Path(self.root) / scene
        return read_scene(folder), read_truth(folder)

    def stamp(self, scene: str) -> str:
        """A hash of the scene's files."""
        return stamp_of_files(Path(self.root) / scene / name for name in (*IMAGES, BOUNDARY, META))

    def official(self) -> Mapping[str, Sequence[str]]:
        """None comes with a folder."""
        return {}


def _annotated_or_damaged(folder: Path) -> bool:
    # What is damaged stays in the list, so that reading it says what is wrong.
    try:
        return read_truth(folder).support_annotated
    except ValueError:
        return True
