"""Boundaries and the over-segmentation along them at 640 x 480, beside what scikit-image does of colour alone."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
import torch
from pytest_benchmark.fixture import BenchmarkFixture
from skimage.color import rgb2gray
from skimage.filters import sobel
from skimage.segmentation import felzenszwalb, slic, watershed
from torch import Tensor

from blockstab.boundaries import BoundaryMap
from blockstab.boundaries.combination import FixedWeights
from blockstab.boundaries.cues import Cues, cues_of
from blockstab.boundaries.gradients import color_gradients
from blockstab.boundaries.relief import relief
from blockstab.rgbd.cloud import DISPARITY_NOISE
from blockstab.rgbd.frame import Camera, Frame
from blockstab.segments.atoms import over_segment
from tests.block_scene import STACK, picture

PARTS = 200  # about as many as the watershed of the boundaries leaves


@pytest.fixture(scope="module")
def frame() -> Frame:
    """Blocks in twice the size of the tests' picture, with the sensor's noise in depth and colour."""
    small, generator = picture(STACK).frame, torch.Generator().manual_seed(0)
    depth = small.depth.repeat_interleave(2, 0).repeat_interleave(2, 1)
    noise = DISPARITY_NOISE * torch.randn(depth.shape, generator=generator, dtype=torch.float64)
    lost = torch.rand(depth.shape, generator=generator) < 0.02
    depth = torch.where((depth > 0) & ~lost, 1 / (1 / depth.clamp(min=0.1) + noise), 0.0)
    color = small.color.repeat_interleave(2, 0).repeat_interleave(2, 1).long()
    color = (color + torch.randint(-6, 7, color.shape, generator=generator)).clamp(0, 255).to(torch.uint8)
    camera = Camera(2 * small.camera.fx, 2 * small.camera.fy, 2 * small.camera.cx, 2 * small.camera.cy)
    return Frame("blocks", color, depth, camera)


@pytest.mark.benchmark(group="over-segmentation of 640 x 480 pixels")
def test_blockstab(benchmark: BenchmarkFixture, frame: Frame) -> None:
    def atoms() -> Tensor:
        return over_segment(FixedWeights()(cues_of(frame)).strength, frame.depth > 0)

    assert int(benchmark(atoms).max()) > 10


@pytest.mark.benchmark(group="over-segmentation of 640 x 480 pixels")
@pytest.mark.parametrize("method", ["watershed", "slic", "felzenszwalb"])
def test_scikit_image(benchmark: BenchmarkFixture, frame: Frame, method: str) -> None:
    color = frame.color.numpy()
    methods: dict[str, Callable[[], np.ndarray]] = {
        "watershed": lambda: watershed(sobel(rgb2gray(color)), markers=PARTS),
        "slic": lambda: slic(color, n_segments=PARTS),
        "felzenszwalb": lambda: felzenszwalb(color, scale=200, sigma=1.0, min_size=25),
    }
    assert int(benchmark(methods[method]).max()) > 10


@pytest.mark.benchmark(group="parts of it")
def test_relief(benchmark: BenchmarkFixture, frame: Frame) -> None:
    assert benchmark(relief, frame).shape == (3, 4, 480, 640)


@pytest.mark.benchmark(group="parts of it")
def test_color_gradients(benchmark: BenchmarkFixture, frame: Frame) -> None:
    assert benchmark(color_gradients, frame.color).shape == (4, 4, 480, 640)


@pytest.mark.benchmark(group="parts of it")
def test_combination(benchmark: BenchmarkFixture, frame: Frame) -> None:
    cues: Cues = cues_of(frame)
    found: BoundaryMap = benchmark(FixedWeights(), cues)
    assert float(found.strength.max()) == 1.0


@pytest.mark.benchmark(group="parts of it")
def test_watershed(benchmark: BenchmarkFixture, frame: Frame) -> None:
    strength = FixedWeights()(cues_of(frame)).strength
    assert int(benchmark(over_segment, strength, frame.depth > 0).max()) > 10
