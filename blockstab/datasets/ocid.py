"""The Object Clutter Indoor Dataset: clutter built up thing by thing, on a floor and on a table."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path

from blockstab.datasets.organised import inside, read_frame, read_ids, truth_of
from blockstab.datasets.truth import Truth
from blockstab.determinism.sources import stamp_of_files
from blockstab.rgbd.frame import Camera, Frame, read_images
from blockstab.rgbd.reading import FrameError, depth_file

_CAMERA, _SIZE = Camera(570.34, 570.34, 319.5, 239.5), (640, 480)
_BACKGROUND = {"floor": (1,), "table": (1, 2)}
_IMAGES = ("rgb", "depth", "label")
_DEEPEST = 8


@dataclass(frozen=True)
class OCID:
    """Object Clutter Indoor Dataset (Suchi, Patten, Fischinger and Vincze 2019, "EasyLabel").

    Layout::

        root/ARID20/{floor,table}/{bottom,top}/seq01/{rgb,depth,label}/STEM.png and pcd/STEM.pcd
        root/{ARID10,YCB10}/{floor,table}/{bottom,top}/{box,curved,mixed,...}/seq01/...

    The root may be any folder of these. A view is read from its three images: depth in mm, taken by an Asus
    Xtion with a focal length of 570.34 pixels. Where one is not there, it is read from the organised cloud,
    with the cloud's label field and the camera its points tell. Links to folders are not followed.

    Labels are 0 unknown; 1 the floor or, in a table scene, what lies beyond the table; 2 in a table scene the
    table; the rest objects. So the loaders of two segmentation networks read them (Xie et al. 2020,
    "UOIS-Net"; Xiang et al. 2020, "UCN").

    Args:
        root: the folder.
    """

    root: str | Path
    name: str = "OCID"

    def scenes(self) -> list[str]:
        """The names of the views, sorted: folder below the root and stem, joined by "-".

        Raises:
            ValueError: there is none, or two have one name.
        """
        return list(self._views)

    def read(self, scene: str) -> tuple[Frame, Truth]:
        """One view.

        Raises:
            FrameError: a file is missing, damaged, without labels or links out of the root.
        """
        *images, cloud = [inside(file, Path(self.root)) for file in self._files(scene)]
        whole = all(file.is_file() for file in images)
        frame = _from_images(images, scene) if whole else read_frame(cloud, scene)
        if frame.label is None:
            raise FrameError(f"{cloud}: must have a field label, but has none; or add {images[2]}.")
        places = [part for part in cloud.resolve().parts if part in _BACKGROUND]
        if not places:
            raise FrameError(
                f"{cloud}: must lie under a folder floor or table, which says what the labels mean, but does "
                "not; keep the folders of the set."
            )
        background = _BACKGROUND[places[-1]]
        return replace(frame, background_ids=background), truth_of(frame.label, background)

    def stamp(self, scene: str) -> str:
        """A hash of the view's files."""
        return stamp_of_files(self._files(scene))

    def official(self) -> Mapping[str, Sequence[str]]:
        """None came with the set."""
        return {}

    def _files(self, scene: str) -> list[Path]:
        """The three images and the cloud."""
        if scene not in self._views:
            raise FrameError(f"{self.root}: holds no view {scene}; choose one of scenes().")
        sequence, stem = self._views[scene]
        return [*(sequence / kind / f"{stem}.png" for kind in _IMAGES), sequence / "pcd" / f"{stem}.pcd"]

    # Walking thousands of folders takes longer than reading a view.
    @cached_property
    def _views(self) -> dict[str, tuple[Path, str]]:
        """Sequence and stem of each view, by name."""
        root, views = Path(self.root), {}
        for sequence in _sequences(root, _DEEPEST) if root.is_dir() else ():
            place = sequence.relative_to(root).parts
            stems = {file.stem for kind in ("rgb/*.png", "pcd/*.pcd") for file in sequence.glob(kind)}
            for stem in stems:
                name = "-".join((*place, stem))
                if name in views:
                    raise ValueError(f"{root} holds two views that would be called {name}; rename one.")
                views[name] = (sequence, stem)
        if not views:
            raise ValueError(f"{root} holds no sequence (a folder with rgb or pcd, not behind a link).")
        return dict(sorted(views.items()))


def _sequences(folder: Path, depth: int) -> Iterator[Path]:
    """Folders that hold `rgb` or `pcd`, at most so deep."""
    inner = sorted(child for child in folder.iterdir() if child.is_dir() and not child.is_symlink())
    if {"rgb", "pcd"} & {child.name for child in inner}:
        yield folder
    elif depth:
        for child in inner:
            yield from _sequences(child, depth - 1)


def _from_images(images: Sequence[Path], scene: str) -> Frame:
    color, depth, label = images
    header = depth_file(depth)
    if (header.width, header.height) != _SIZE:
        raise FrameError(
            f"{depth}: must have the {_SIZE[0]} x {_SIZE[1]} pixels of the set's camera, but has {header.width} x "
            f"{header.height}; use the images as they came."
        )
    frame = read_images(color, depth, _CAMERA, name=scene)
    return replace(frame, label=read_ids(label, frame))
