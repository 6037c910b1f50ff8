"""Arrays of HDF5 files, however they are stored, and what is refused before it takes memory."""

from __future__ import annotations

import zlib
from pathlib import Path

import h5py
import numpy as np
import pytest

from blockstab.datasets.formats.hdf5 import open_arrays
from blockstab.rgbd.reading import FrameError

VALUES = np.random.default_rng(0).integers(1000, size=(3, 50, 70)).astype("u2")
STORED = {
    "contiguous": {},
    "chunked": {"chunks": (1, 50, 70)},
    "deflated": {"chunks": (2, 16, 70), "compression": "gzip"},
    "shuffled": {"chunks": (1, 7, 11), "compression": "gzip", "shuffle": True},
}


@pytest.mark.parametrize("stored", STORED)
def test_an_entry_is_that_which_h5py_reads(tmp_path: Path, stored: str) -> None:
    with h5py.File(tmp_path / "a.mat", "w") as file:
        file.create_dataset("labels", data=VALUES, **STORED[stored])
    with open_arrays(tmp_path / "a.mat") as arrays:
        assert arrays.count("labels") == 3
        for index in range(3):
            np.testing.assert_array_equal(arrays.entry("labels", index, (50, 70), "u2"), VALUES[index])


def test_an_entry_of_another_shape_type_or_place_is_refused(tmp_path: Path) -> None:
    with h5py.File(tmp_path / "a.mat", "w") as file:
        file.create_dataset("labels", data=VALUES)
    for wanted in ((0, (50, 71), "u2"), (0, (50, 70), "u1"), (3, (50, 70), "u2"), (-1, (50, 70), "u2")):
        with (
            pytest.raises(FrameError, match="labels must have an entry"),
            open_arrays(tmp_path / "a.mat") as arrays,
        ):
            arrays.entry("labels", *wanted)


def test_a_chunk_that_inflates_to_more_than_it_should_is_refused(tmp_path: Path) -> None:
    with h5py.File(tmp_path / "a.mat", "w") as file:
        made = file.create_dataset("labels", (1, 50, 70), "u2", chunks=(1, 50, 70), compression="gzip")
        made.id.write_direct_chunk((0, 0, 0), zlib.compress(bytes(7001)))
    with pytest.raises(FrameError, match="must hold 7000 bytes"), open_arrays(tmp_path / "a.mat") as arrays:
        arrays.entry("labels", 0, (50, 70), "u2")


def test_more_entries_than_the_file_has_bytes_for_are_refused(tmp_path: Path) -> None:
    with h5py.File(tmp_path / "a.mat", "w") as file:
        file.create_dataset("labels", (10**9, 50, 70), "u2", chunks=(1, 50, 70), compression="gzip")
    with (
        pytest.raises(FrameError, match="labels must fit in the file"),
        open_arrays(tmp_path / "a.mat") as arrays,
    ):
        arrays.count("labels")


def test_arrays_in_other_files_are_refused(tmp_path: Path) -> None:
    with h5py.File(tmp_path / "secret.mat", "w") as file:
        file.create_dataset("labels", data=VALUES)
    VALUES.tofile(tmp_path / "raw")
    with h5py.File(tmp_path / "a.mat", "w") as file:
        file["linked"] = h5py.ExternalLink("secret.mat", "labels")
        file["soft"] = h5py.SoftLink("/kept")
        file.create_dataset("kept", data=VALUES)
        file.create_dataset("raw", VALUES.shape, "u2", external=[(str(tmp_path / "raw"), 0, VALUES.nbytes)])
        layout = h5py.VirtualLayout(VALUES.shape, "u2")
        layout[:] = h5py.VirtualSource("secret.mat", "labels", VALUES.shape)
        file.create_virtual_dataset("virtual", layout)
    for name in ("linked", "soft", "raw", "virtual"):
        with (
            pytest.raises(FrameError, match="must lie in the file"),
            open_arrays(tmp_path / "a.mat") as arrays,
        ):
            arrays.entry(name, 0, (50, 70), "u2")


def test_words_are_read_through_their_references(tmp_path: Path) -> None:
    with h5py.File(tmp_path / "a.mat", "w") as file:
        names = file.create_dataset("names", (1, 2), dtype=h5py.ref_dtype)
        for i, word in enumerate(("floor", "Tür")):
            letters = np.frombuffer(word.encode("utf-16-le"), "u2")[:, None]
            names[0, i] = file.create_dataset(f"word{i}", data=letters).ref
    with open_arrays(tmp_path / "a.mat") as arrays:
        assert [arrays.word("names", i) for i in range(2)] == ["floor", "Tür"]
        with pytest.raises(FrameError, match="names must refer to a word 2"):
            arrays.word("names", 2)


@pytest.mark.parametrize("content", [b"", b"no HDF5 at all", b"\x89HDF\r\n\x1a\n" + bytes(500)])
def test_another_file_is_one_line(tmp_path: Path, content: bytes) -> None:
    (tmp_path / "a.mat").write_bytes(content)
    with (
        pytest.raises(FrameError, match=r"a\.mat: must be a whole HDF5 file") as caught,
        open_arrays(tmp_path / "a.mat"),
    ):
        pass
    assert "\n" not in str(caught.value)
