"""A miniature of NYU Depth v2: three small rooms in files of the published layout."""

from __future__ import annotations

from pathlib import Path

import h5py
import numpy as np
import scipy.io

from blockstab.datasets.nyu import LABELLED, SPLIT, SUPPORTS

WORDS = ("book", "floor", "table", "wall", "cup")
BOOK, FLOOR, TABLE, WALL, CUP = range(1, 6)
COUNT = 3


def write_nyu(root: Path) -> None:
    """The labelled images, the support labels and the split."""
    write_labelled(root / LABELLED)
    write_supports(root / SUPPORTS)
    scipy.io.savemat(root / SPLIT, {"trainNdxs": [[1], [3]], "testNdxs": [[2]]}, do_compression=True)


def labels(index: int) -> tuple[np.ndarray, np.ndarray]:
    """(480, 640) classes and instances: a table with a book and two cups on it, and a speck of a cup."""
    classes, instances = np.full((480, 640), WALL, dtype="u2"), np.ones((480, 640), dtype="u1")
    for rows, columns, kind, own in (
        ((300, 480), (0, 640), FLOOR, 1),
        ((200, 350), (100, 500), TABLE, 1),
        ((180, 220), (150, 200), CUP, 2),
        ((180, 220), (250, 300), CUP, 1),
        ((190, 210), (350 + index, 400), BOOK, 1),
        ((100, 103), (100, 103), CUP, 3),
        ((0, 480), (0, 60), 0, 0),
    ):
        classes[slice(*rows), slice(*columns)] = kind
        instances[slice(*rows), slice(*columns)] = own
    return classes, instances


def depth(index: int) -> np.ndarray:
    """(480, 640) metres: a slanted wall, with a hole."""
    metres = np.linspace(1.0, 3.0, 640, dtype="f4") + np.zeros((480, 1), dtype="f4") + index
    metres[400:420, 300:320] = 0
    return metres


def color(index: int) -> np.ndarray:
    """(480, 640, 3): a ramp in each channel."""
    row, column = np.mgrid[:480, :640]
    return np.stack([row % 256, column % 256, (row + column + index) % 256], axis=2).astype("u1")


def write_labelled(path: Path) -> None:
    """The file of MATLAB 7.3, whose arrays are stored with their axes in the other order."""
    with h5py.File(path, "w", userblock_size=512) as file:
        arrays = {
            "images": np.stack([color(i).transpose(2, 1, 0) for i in range(COUNT)]),
            "rawDepths": np.stack([depth(i).T for i in range(COUNT)]),
            "labels": np.stack([labels(i)[0].T for i in range(COUNT)]),
            "instances": np.stack([labels(i)[1].T for i in range(COUNT)]),
        }
        for name, values in arrays.items():
            chunks = (1, *(min(size, 160) for size in values.shape[1:]))
            file.create_dataset(
                name, data=values, chunks=chunks, compression="gzip", shuffle=name == "labels"
            )
        refs = file.create_group("#refs#")
        names = file.create_dataset("names", (1, len(WORDS)), dtype=h5py.ref_dtype)
        for i, word in enumerate(WORDS):
            letters = np.frombuffer(word.encode("utf-16-le"), "u2")[:, None]
            names[0, i] = refs.create_dataset(word, data=letters).ref


def write_supports(path: Path, farthest: int = 6) -> None:
    """Regions: 1 book, 2 floor, 3 table, 4 wall, 5 and 6 cups; the table stands on the floor, the rest on it."""
    rows = np.array([[1, 3, 1], [2, 0, 0], [3, 2, 1], [3, 4, 2], [5, -1, 1], [farthest, 3, 1]], dtype="f8")
    cells = np.empty((COUNT, 1), dtype=object)
    for i in range(COUNT):
        cells[i, 0] = rows
    scipy.io.savemat(path, {"supportLabels": cells}, do_compression=True)
