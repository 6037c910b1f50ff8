"""Every stage of the first segmentation at 640 x 480, beside what scikit-image makes of the same picture.

The time of a stage does not hold those of the stages before it. "All" is everything from the image to its regions.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from pytest_benchmark.fixture import BenchmarkFixture
from skimage.color import rgb2gray
from skimage.filters import sobel
from skimage.segmentation import felzenszwalb, slic, watershed
from torch import Tensor

from blockstab.boundaries.combination import FixedWeights
from blockstab.boundaries.cues import cues_of
from blockstab.boundaries.gradients import color_gradients
from blockstab.boundaries.relief import relief
from blockstab.features.appearance import edgelet_appearance
from blockstab.features.regions import viewed_regions
from blockstab.features.views import Views, view
from blockstab.percept import Percept, estimated_ground, perceive
from blockstab.proposals.silberman import Silberman
from blockstab.rgbd.cloud import cloud_from_frame
from blockstab.segments.atoms import make_atoms, over_segment
from blockstab.segments.edgelets import trace_edgelets
from blockstab.segments.hierarchy import build_hierarchy
from blockstab.segments.planes import find_planes
from models.stages import silberman

SEED = 9200
PARTS = 200  # about as many as the atoms

pytestmark = pytest.mark.benchmark(group="first segmentation of 640 x 480 pixels")


@pytest.fixture(scope="module")
def percept() -> Percept:
    pytest.importorskip("mujoco")
    from blockstab.simulation.simulated import Recipe, simulate_scene

    frame, _ = simulate_scene(Recipe("objects", SEED), 3)
    return perceive(frame, estimated_ground)


@pytest.fixture(scope="module")
def views(percept: Percept) -> Views:
    return view(percept)


@pytest.fixture(scope="module")
def merging() -> Silberman:
    return silberman()


def test_boundaries_and_their_watershed(benchmark: BenchmarkFixture, percept: Percept) -> None:
    def basins() -> Tensor:
        return over_segment(FixedWeights()(cues_of(percept.frame)).strength, percept.cloud.valid)

    assert int(benchmark(basins).max()) > 10


def test_color_gradients(benchmark: BenchmarkFixture, percept: Percept) -> None:
    assert benchmark(color_gradients, percept.frame.color).shape == (4, 4, 480, 640)


def test_relief(benchmark: BenchmarkFixture, percept: Percept) -> None:
    assert benchmark(relief, percept.frame).shape == (3, 4, 480, 640)


def test_cues(benchmark: BenchmarkFixture, percept: Percept) -> None:
    benchmark(cues_of, percept.frame)


def test_combination(benchmark: BenchmarkFixture, percept: Percept) -> None:
    benchmark(FixedWeights(), cues_of(percept.frame))


def test_planes(benchmark: BenchmarkFixture, percept: Percept) -> None:
    benchmark(find_planes, percept.cloud)


def test_atoms(benchmark: BenchmarkFixture, percept: Percept) -> None:
    benchmark(over_segment, percept.boundaries.strength, percept.cloud.valid, percept.planes.label)


def test_hierarchy(benchmark: BenchmarkFixture, percept: Percept) -> None:
    benchmark(lambda: build_hierarchy(make_atoms(percept.fine, percept.boundaries.strength)))


def test_edgelets(benchmark: BenchmarkFixture, percept: Percept) -> None:
    benchmark(trace_edgelets, percept.fine)


def test_views(benchmark: BenchmarkFixture, percept: Percept) -> None:
    benchmark(view, percept)


def test_appearance_of_the_atoms(benchmark: BenchmarkFixture, percept: Percept, views: Views) -> None:
    edgelets = trace_edgelets(percept.fine)

    def rows() -> Tensor:
        return edgelet_appearance(viewed_regions(views, percept.fine), edgelets, percept.boundaries)

    assert benchmark(rows).shape == (len(edgelets), 51)


def test_merging_in_five_stages(benchmark: BenchmarkFixture, percept: Percept, merging: Silberman) -> None:
    assert int(benchmark(merging, percept).label.max()) > 1


def test_all(benchmark: BenchmarkFixture, percept: Percept, merging: Silberman) -> None:
    benchmark(lambda: merging(perceive(percept.frame, estimated_ground)))


def test_points_and_normals(benchmark: BenchmarkFixture, percept: Percept) -> None:
    benchmark(cloud_from_frame, percept.frame)


@pytest.mark.parametrize("method", ["watershed", "slic", "felzenszwalb"])
def test_scikit_image(benchmark: BenchmarkFixture, percept: Percept, method: str) -> None:
    color = percept.frame.color.numpy()
    methods: dict[str, Callable[[], np.ndarray]] = {
        "watershed": lambda: watershed(sobel(rgb2gray(color)), markers=PARTS),
        "slic": lambda: slic(color, n_segments=PARTS),
        "felzenszwalb": lambda: felzenszwalb(color, scale=200, sigma=1.0, min_size=25),
    }
    assert int(benchmark(methods[method]).max()) > 10
