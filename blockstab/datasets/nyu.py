"""NYU Depth v2: 1449 labelled images of rooms in one MATLAB 7.3 file."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray

from blockstab.datasets.formats.hdf5 import open_arrays
from blockstab.datasets.formats.matlab import Matrix, read_matlab
from blockstab.datasets.organised import inside
from blockstab.datasets.truth import ObjectTruth, Truth
from blockstab.rgbd.frame import Camera, Frame, check_depth
from blockstab.rgbd.reading import FrameError

LABELLED, SUPPORTS, SPLIT = "nyu_depth_v2_labeled.mat", "support_labels.mat", "splits.mat"
_WIDTH, _HEIGHT = 640, 480
_ROWS, _COLUMNS = slice(44, 471), slice(40, 601)  # rows 45 to 471 and columns 41 to 601, counted from 1
# The published principal point counts pixels from 1.
_CAMERA = Camera(518.858, 519.470, 325.582 - 1 - _COLUMNS.start, 253.736 - 1 - _ROWS.start)
_BACKGROUND = frozenset(("floor", "wall", "ceiling"))
_LEAST_PX = 10
_TYPES = {1: "below", 2: "behind"}
_HIDDEN = -1


@dataclass(frozen=True)
class NYUv2:
    """NYU Depth v2 (Silberman, Hoiem, Kohli and Fergus 2012).

    Layout::

        root/nyu_depth_v2_labeled.mat
        root/support_labels.mat    optional: who supports whom
        root/splits.mat            optional: the official split, 795 to train and 654 to test

    Images are cropped to 427 x 561 pixels, as by their authors; depth is that which was measured, not filled in.
    A region is a pair of class and instance with at least 10 pixels. Regions are numbered from 1, by class and
    then by instance, so that the ids are those of the support labels. Floors, walls and ceilings are background.

    Of a region with a hidden supporter, which has no id, supporters are not known.

    Args:
        root: the folder.
    """

    root: str | Path
    name: str = "NYUv2"

    def scenes(self) -> list[str]:
        """`nyu_0001` and so on.

        Raises:
            FrameError: the file is missing or damaged.
        """
        with open_arrays(self._file(LABELLED)) as arrays:
            return [_scene(index) for index in range(arrays.count("labels"))]

    def read(self, scene: str) -> tuple[Frame, Truth]:
        """One image.

        Raises:
            FrameError: it is damaged, or the support labels are of other regions.
        """
        index, file = self._index(scene), self._file(LABELLED)
        with open_arrays(file) as arrays:
            color = np.stack(
                [_cropped(c) for c in arrays.entry("images", index, (3, _WIDTH, _HEIGHT), "u1")], 2
            )
            depth = _cropped(arrays.entry("rawDepths", index, (_WIDTH, _HEIGHT), "f4")).astype(np.float64)
            classes = _cropped(arrays.entry("labels", index, (_WIDTH, _HEIGHT), "u2"))
            instances = _cropped(arrays.entry("instances", index, (_WIDTH, _HEIGHT), "u1"))
            label, of_region = regions(classes, instances)
            words = {c: arrays.word("names", c - 1) for c in sorted(set(of_region) - {0})}
        depth = np.where(np.isfinite(depth) & (depth > 0), depth, 0.0)
        check_depth(depth, file, "m")
        ids = range(1, len(of_region) + 1)
        background = tuple(i for i in ids if words.get(of_region[i - 1]) in _BACKGROUND)
        supports = self._supports(index, len(of_region))
        objects = tuple(
            replace(supports.get(i, ObjectTruth(i)), category=words.get(of_region[i - 1]))
            for i in ids
            if i not in background
        )
        frame = Frame(
            scene,
            torch.from_numpy(color),
            torch.from_numpy(depth),
            _CAMERA,
            torch.from_numpy(label),
            background,
        )
        return frame, Truth(background, objects, None, support_annotated=bool(supports))

    def stamp(self, scene: str) -> str:
        """The scene, and size and time of the files, which are too large to be read again and again."""
        files = [self._file(name) for name in (LABELLED, SUPPORTS)]
        told = [file.stat() if file.is_file() else None for file in files]
        return " ".join([scene, *(f"{t.st_size}:{t.st_mtime_ns}" if t else "-" for t in told)])

    def official(self) -> Mapping[str, Sequence[str]]:
        """`train` and `test` of splits.mat, if it is there."""
        file = self._file(SPLIT)
        if not file.is_file():
            return {}
        found, scenes = read_matlab(file), self.scenes()
        parts = {}
        for part in ("train", "test"):
            numbers = _variable(found, f"{part}Ndxs", file).numbers().reshape(-1)
            if not ((numbers >= 1) & (numbers <= len(scenes)) & (numbers % 1 == 0)).all():
                raise FrameError(
                    f"{file}: {part}Ndxs must be images from 1 to {len(scenes)}, but are not; copy it again."
                )
            parts[part] = [scenes[int(number) - 1] for number in numbers]
        return parts

    def _file(self, name: str) -> Path:
        return inside(Path(self.root) / name, Path(self.root))

    def _index(self, scene: str) -> int:
        number = scene.removeprefix("nyu_")
        if not (number.isascii() and number.isdigit() and scene == _scene(int(number) - 1)):
            raise FrameError(f"{self.root}: holds no image {scene}; choose one of scenes().")
        return int(number) - 1

    def _supports(self, index: int, regions_there: int) -> dict[int, ObjectTruth]:
        """Ground truth of the regions whose supporters are all known."""
        file = self._file(SUPPORTS)
        if not file.is_file():
            return {}
        cells = self._support_cells
        rows = cells[index].numbers() if index < len(cells) else np.empty((0, 3))
        if rows.ndim != 2 or rows.shape[1] != 3 or not (rows % 1 == 0).all():
            raise FrameError(
                f"{file}: image {index + 1} must have rows of three whole numbers; copy it again."
            )
        # A map that was numbered otherwise would give other things' supports without a word.
        if rows.size and not (rows[:, :2].max() <= regions_there and rows[:, 0].min() >= 1):
            raise FrameError(
                f"{file}: must speak of the {regions_there} regions of image {index + 1}, but speaks of region "
                f"{int(rows[:, :2].max())}; take it from the release of the labelled images."
            )
        return _by_region(rows.astype(np.int64).tolist())

    @cached_property
    def _support_cells(self) -> list[Matrix]:
        file = self._file(SUPPORTS)
        return _variable(read_matlab(file), "supportLabels", file).cells()


def regions(
    classes: NDArray[np.integer[Any]], instances: NDArray[np.integer[Any]]
) -> tuple[NDArray[np.int64], list[int]]:
    """Number the regions as the support labels do.

    Returns:
        (H, W) ids, 0 = none, and the class of each region from 1.
    """
    pairs = classes.astype(np.int64) * 256 + instances
    found, place, pixels = np.unique(pairs, return_inverse=True, return_counts=True)
    kept = (found > 0) & (pixels >= _LEAST_PX)
    number = np.where(kept, np.cumsum(kept), 0)
    return number[place.reshape(pairs.shape)], (found[kept] // 256).tolist()


def _by_region(rows: list[list[int]]) -> dict[int, ObjectTruth]:
    of_region: dict[int, dict[int, str]] = {}
    hidden = set()
    for supported, supporter, kind in rows:
        known = of_region.setdefault(supported, {})
        if supporter == _HIDDEN:
            hidden.add(supported)
        elif supporter > 0 and kind in _TYPES and supporter != supported:
            known.setdefault(supporter, _TYPES[kind])
    return {
        region: ObjectTruth(region, supported_by=tuple(by), support_types=tuple(by.values()))
        for region, by in of_region.items()
        if region not in hidden
    }


def _variable(found: Mapping[str, Matrix], name: str, file: Path) -> Matrix:
    if name not in found:
        raise FrameError(f"{file}: must hold {name}, but has {', '.join(found)!r:.80}; copy it again.")
    return found[name]


def _cropped(image: NDArray[Any]) -> NDArray[Any]:
    """(427, 561) of an image (640, 480), which MATLAB stores column by column."""
    return np.ascontiguousarray(image.T[_ROWS, _COLUMNS])


def _scene(index: int) -> str:
    return f"nyu_{index + 1:04d}"
