"""Run lengths against counting pixels, and against the COCO API."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from blockstab.proposals.rle import inside, run_lengths
from blockstab.rgbd.reading import FrameError
from tests.proposals.mask_files import letters_of, runs_of


def decoded(counts: object, height: int, width: int) -> NDArray[np.bool_]:
    segmentation = {"size": [height, width], "counts": counts}
    return inside(run_lengths(segmentation, height, width, "f: mask 1"), height, width)


def drawn(seed: int, height: int = 23, width: int = 31) -> NDArray[np.bool_]:
    """Masks from dense noise to a few large patches, empty and full ones too."""
    random = np.random.default_rng(seed)
    coarse = random.random((height, width)) < (0.0, 0.02, 0.5, 0.98, 1.0)[seed % 5]
    grown = np.kron(coarse, np.ones((1 + seed % 4, 1 + seed % 3), dtype=bool))
    return grown[:height, :width]


def test_runs_go_down_the_columns_and_begin_outside() -> None:
    expected = np.array([[0, 1, 0], [0, 1, 1]], dtype=bool)
    assert np.array_equal(decoded([2, 2, 1, 1], 2, 3), expected)
    assert np.array_equal(decoded([0, 2, 4], 2, 3), np.array([[1, 0, 0], [1, 0, 0]], dtype=bool))


def test_letters_stand_for_numbers_of_five_bits_and_from_the_fourth_on_for_differences() -> None:
    # 2, 3, 40 = 8 + 32 * 1, then 3 - 3 = 0 and 12 - 40 = -28 = 4 - 32, the last with its sign in the second letter.
    text = "".join(chr(48 + bits) for bits in (2, 3, 8 + 32, 1, 0, 4 + 32, 31))
    segmentation = {"size": [6, 10], "counts": text}
    assert run_lengths(segmentation, 6, 10, "f").tolist() == [2, 3, 40, 3, 12]


@pytest.mark.parametrize("seed", range(10))
def test_lists_and_strings_give_the_mask_back(seed: int) -> None:
    mask = drawn(seed)
    assert np.array_equal(decoded(runs_of(mask), *mask.shape), mask)
    assert np.array_equal(decoded(letters_of(runs_of(mask)), *mask.shape), mask)


@pytest.mark.filterwarnings("ignore::DeprecationWarning")  # of what the COCO API does with numpy
@pytest.mark.parametrize(("height", "width"), [(23, 31), (1, 700), (480, 640)])
def test_masks_are_those_of_the_coco_api(height: int, width: int) -> None:
    coco = pytest.importorskip("pycocotools.mask", reason="pycocotools is the reference")
    for seed in range(20):
        mask = drawn(seed, height, width)
        text = coco.encode(np.asfortranarray(mask.astype(np.uint8)))["counts"].decode()
        assert np.array_equal(decoded(text, *mask.shape), mask)
        runs = run_lengths({"size": [*mask.shape], "counts": text}, *mask.shape, "f").tolist()
        theirs = coco.frPyObjects({"size": [*mask.shape], "counts": runs}, *mask.shape)
        assert np.array_equal(coco.decode(theirs).astype(bool), mask)


def test_the_longest_run_of_the_largest_image_is_read() -> None:
    runs = [0, 64_000_000]
    segmentation = {"size": [8000, 8000], "counts": letters_of(runs)}
    assert run_lengths(segmentation, 8000, 8000, "f").tolist() == runs


@pytest.mark.parametrize(
    "counts",
    [
        [2, 2],  # too few
        [2, 2, 3],  # too many
        [-1, 7],
        [2.0, 4.0],
        [True, 5],
        [2**70],
        [0] * 7 + [6],  # more runs than pixels
        [],
        "",
        None,
        6,
        "é",
        "\x00",
        "~",
        letters_of([2, 3]),
        letters_of([7, -1]),
        letters_of([6]) + "P",  # the last letter says that another follows
        "V" + "P" * 5 + "0",  # 6 in seven letters
        "v",  # 6 with a seventh bit
        "0" * 100,
    ],
)
def test_runs_that_are_no_mask_are_refused(counts: Any) -> None:
    with pytest.raises(FrameError, match=r"^f: mask 1: counts must be run lengths .* the 6 pixels"):
        decoded(counts, 2, 3)


def test_a_size_is_refused_before_its_pixels_take_memory() -> None:
    huge = {"size": [2**31, 2**31], "counts": [2**62]}
    with pytest.raises(FrameError, match=r"must be that of the image, \[2, 3\] .* but it is \[2147483648"):
        run_lengths(huge, 2, 3, "f: mask 1")


@pytest.mark.parametrize(
    ("segmentation", "came"),
    [([[0.0, 0.0, 2.0, 0.0, 2.0, 1.0]], "polygons"), (None, "None"), ({"size": [2, 3]}, "{'size': ")],
)
def test_what_is_no_run_lengths_is_said(segmentation: Any, came: str) -> None:
    with pytest.raises(FrameError, match=f"must be run lengths, .* but it is {came}"):
        run_lengths(segmentation, 2, 3, "f: mask 1")
