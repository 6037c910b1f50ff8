"""The Object Segmentation Database: organised clouds of things on a table."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import torch
from torch import Tensor

from blockstab.datasets.organised import inside, read_frame, read_ids, truth_of
from blockstab.datasets.truth import LARGEST_ID, Truth
from blockstab.determinism.sources import stamp_of_files
from blockstab.rgbd.frame import Frame
from blockstab.rgbd.reading import FrameError

_TABLE = 1
_FOLDERS = ("", "learn", "test", "pcd")
_PARTS = {"learn": "train", "test": "test"}


@dataclass(frozen=True)
class OSD:
    """Object Segmentation Database (Richtsfeld et al. 2012), and its modified form mOSD (Alexandrov).

    Layout, any of::

        root/learn0.pcd                                   labelled clouds
        root/learn/learn0.pcd, root/test/test0.pcd        those of mOSD, in the data of the Point Cloud Library
        root/pcd/learn0.pcd, root/annotation/learn0.png   OSD 0.2

    Labels of a cloud are 0 unknown, 1 table, 2 and up objects. mOSD gives each visible part an id: the parts
    of the table have 1 to 9, those of the first object 20 to 29, of the next 30 to 39; parts are merged here.
    Where there is an annotation, it counts instead: 0 is what is no object, which becomes 1, and 1 and up are
    objects, which become 2 and up. The camera is found from each cloud.

    Args:
        root: the folder.
    """

    root: str | Path
    name: str = "OSD"

    def scenes(self) -> list[str]:
        """The names of the clouds, less their ending, sorted.

        Raises:
            ValueError: there is none, or two have one name.
        """
        names = [file.stem for folder in _FOLDERS for file in (Path(self.root) / folder).glob("*.pcd")]
        if not names or len(set(names)) < len(names):
            raise ValueError(
                f"{self.root} must hold .pcd clouds, each with a name of its own, in itself, learn, test or pcd, "
                f"but holds {len(names)} with {len(set(names))} names."
            )
        return sorted(names)

    def read(self, scene: str) -> tuple[Frame, Truth]:
        """One scene.

        Raises:
            FrameError: a file is missing, damaged, without labels or links out of the root.
        """
        cloud, annotation = self._files(scene)
        frame = read_frame(inside(cloud, Path(self.root)), scene)
        if annotation.is_file():
            label = 1 + read_ids(inside(annotation, Path(self.root)), frame)
        elif frame.label is not None:
            label = _merged(frame.label)
        else:
            raise FrameError(f"{cloud}: must have a field label, but has none; or add {annotation}.")
        if int(label.max()) > LARGEST_ID:
            raise FrameError(
                f"{annotation}: ids must be below {LARGEST_ID}, but one is not; number objects anew."
            )
        return replace(frame, label=label, background_ids=(_TABLE,)), truth_of(label, (_TABLE,))

    def stamp(self, scene: str) -> str:
        """A hash of the scene's files."""
        return stamp_of_files(self._files(scene))

    def official(self) -> Mapping[str, Sequence[str]]:
        """`train` is the learn set, `test` the test set; empty where a name begins with neither."""
        scenes = self.scenes()
        parts = {part: [s for s in scenes if s.startswith(set_)] for set_, part in _PARTS.items()}
        return parts if sum(map(len, parts.values())) == len(scenes) else {}

    def _files(self, scene: str) -> tuple[Path, Path]:
        """The cloud, and the annotation that there may be."""
        root = Path(self.root)
        clouds = [root / folder / f"{scene}.pcd" for folder in _FOLDERS]
        found = next((cloud for cloud in clouds if cloud.is_file()), clouds[0])
        return found, root / "annotation" / f"{scene}.png"


def _merged(label: Tensor) -> Tensor:
    """One id for each object of mOSD; ids without parts stay."""
    # Parts are numbered from 20, so only a scene whose parts are merged already can have 10 to 19.
    in_parts = bool((label >= 20).any()) and not bool(((label >= 10) & (label < 20)).any())
    return torch.where(label < 10, label.clamp(max=_TABLE), label // 10) if in_parts else label
