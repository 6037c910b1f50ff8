"""SUN RGB-D: rooms seen by four kinds of sensors, with polygons around objects."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from reprlib import repr as shown

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from blockstab.datasets.organised import inside, lies_in
from blockstab.datasets.polygons import polygon_labels
from blockstab.datasets.truth import ObjectTruth, Truth
from blockstab.determinism.sources import stamp_of_files
from blockstab.rgbd.frame import Camera, Frame, decoded
from blockstab.rgbd.reading import FrameError, color_file, depth_file

_ANNOTATION = "annotation2Dfinal/index.json"
_BACKGROUND = frozenset(("floor", "wall", "ceiling"))
_DEEPEST = 8
_MOST_TEXT_BYTES = 4096
_RIGID = 0.05


@dataclass(frozen=True)
class SUNRGBD:
    """SUN RGB-D (Song, Lichtenberg and Xiao 2015).

    Layout::

        root/{kv1,kv2,realsense,xtion}/.../IMAGE/image/*.jpg
                                             .../depth_bfx/*.png (filled in) or depth/*.png
                                             .../intrinsics.txt         nine numbers
                                             .../extrinsics/*.txt       optional: how the camera was tilted
                                             .../annotation2Dfinal/index.json

    The root may be any folder of these. Depth is that which was measured, where there is a folder depth, else
    the other; its 16 bits are a length in millimetres, turned left by three. The last tilt by name counts. A pixel
    belongs to the last polygon around it; an object may have several. Floor, wall and ceiling are background. 3-D
    boxes are not read. Links to folders are not followed.

    Args:
        root: the folder.
    """

    root: str | Path
    name: str = "SUNRGBD"

    def scenes(self) -> list[str]:
        """The names of the images, sorted: folders below the root, joined by "-".

        Raises:
            ValueError: there is none, or two have one name.
        """
        return list(self._folders)

    def read(self, scene: str) -> tuple[Frame, Truth]:
        """One image.

        Raises:
            FrameError: a file is missing, damaged or links out of the root.
        """
        folder = self._folder(scene)
        image, raw, intrinsics = (
            self._only(folder, ("image/*.jpg", "image/*.png")),
            self._only(folder, ("depth/*.png", "depth_bfx/*.png")),
            self._inside(folder / "intrinsics.txt"),
        )
        fx, _, cx, _, fy, cy, *_ = _numbers(intrinsics, 9).tolist()
        frame = decoded(
            color_file(image), depth_file(raw), Camera(fx, fy, cx, cy), _metres, scene, str(intrinsics)
        )
        label, names = polygon_labels(self._inside(folder / _ANNOTATION), tuple(frame.depth.shape))
        present = [i for i in torch.unique(label).tolist() if i > 0]
        background = tuple(i for i in present if names[i] in _BACKGROUND)
        objects = tuple(ObjectTruth(i, category=names[i]) for i in present if i not in background)
        up = self._up(folder)
        frame = replace(frame, label=label, background_ids=background, up_camera=up)
        return frame, Truth(background, objects, up, support_annotated=False)

    def stamp(self, scene: str) -> str:
        """A hash of the image's files."""
        folder, root = self._folder(scene), Path(self.root)
        found = [
            f
            for pattern in ("image/*", "depth/*", "depth_bfx/*", "extrinsics/*")
            for f in folder.glob(pattern)
        ]
        files = [*sorted(found), folder / "intrinsics.txt", folder / _ANNOTATION]
        return stamp_of_files([file for file in files if lies_in(file, root)])

    def official(self) -> Mapping[str, Sequence[str]]:
        """None: the published one names folders of its authors' machine."""
        return {}

    @cached_property
    def _folders(self) -> dict[str, Path]:
        """The folder of each image, by name."""
        root, folders = Path(self.root), {}
        for folder in sorted(_images(root, _DEEPEST)) if root.is_dir() else ():
            name = "-".join(folder.relative_to(root).parts) or folder.resolve().name
            if name in folders:
                raise ValueError(f"{root} holds two images that would be called {name}; rename one.")
            folders[name] = folder
        if not folders:
            raise ValueError(f"{root} holds no image (a folder with intrinsics.txt, not behind a link).")
        return folders

    def _folder(self, scene: str) -> Path:
        if scene not in self._folders:
            raise FrameError(f"{self.root}: holds no image {scene}; choose one of scenes().")
        return self._folders[scene]

    def _only(self, folder: Path, patterns: Sequence[str]) -> Path:
        """The first file of the first pattern that has one."""
        found = [file for pattern in patterns for file in sorted(folder.glob(pattern))]
        return self._inside(found[0] if found else folder / patterns[0])

    def _inside(self, path: Path) -> Path:
        return inside(path, Path(self.root))

    def _up(self, folder: Path) -> Tensor | None:
        """Up in the camera frame: the tilt turns the camera's y axis, which looks down, upright."""
        files = sorted((folder / "extrinsics").glob("*.txt"))
        if not files:
            return None
        tilt = _numbers(self._inside(files[-1]), 12).reshape(3, 4)[:, :3]
        if not np.allclose(tilt @ tilt.T, np.eye(3), atol=_RIGID):
            raise FrameError(
                f"{files[-1]}: must hold rows of a rotation and a shift, but the rotation is {shown(tilt.tolist())}; "
                "copy it again."
            )
        return -torch.from_numpy(tilt[1] / np.linalg.norm(tilt[1]))


def _images(folder: Path, depth: int) -> Iterator[Path]:
    """Folders with the numbers of a camera, at most so deep."""
    if (folder / "intrinsics.txt").exists():
        yield folder
    elif depth:
        for child in sorted(folder.iterdir()):
            if child.is_dir() and not child.is_symlink():
                yield from _images(child, depth - 1)


def _metres(raw: NDArray[np.uint16]) -> NDArray[np.float64]:
    """Metres of what a depth image holds: millimetres, their bits turned left by three."""
    return ((raw >> 3) | (raw << 13)).astype(np.float64) / 1000.0


def _numbers(path: Path, count: int) -> NDArray[np.float64]:
    """So many finite numbers of a small text file."""
    try:
        with path.open("rb") as file:
            text = file.read(_MOST_TEXT_BYTES)
    except OSError as error:
        raise FrameError(
            f"{path}: must be a readable file, but cannot be opened ({error.strerror}); check the path."
        ) from None
    try:
        numbers = np.array([float(word) for word in text.split()])
    except ValueError:
        numbers = np.empty(0)
    if numbers.shape != (count,) or not np.isfinite(numbers).all():
        raise FrameError(f"{path}: must hold {count} finite numbers, but is {shown(text)}; copy it again.")
    return numbers
