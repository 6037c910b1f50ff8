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

from blockstab.boundaries.cues import cues_of
from blockstab.boundaries.edge_models import FixedWeights
from blockstab.boundaries.gradients import color_gradients
from blockstab.boundaries.relief import relief
from blockstab.features.appearance.pair_columns import edgelet_appearance
from blockstab.features.appearance.regions import viewed_regions
from blockstab.features.appearance.views import Views, view
from blockstab.observation import Observation, estimated_ground, observe
from blockstab.proposals.silberman import Silberman
from blockstab.rgbd.cloud import cloud_from_frame
from blockstab.segments.atoms import make_atoms, over_segment
from blockstab.segments.edgelets import trace_edgelets
from blockstab.segments.hierarchy import build_hierarchy
from blockstab.segments.plane_map import find_planes
from models.stages.stages import silberman

SEED = 9200
PARTS = 200  # about as many as the atoms

pytestmark = pytest.mark.benchmark(group="first segmentation of 640 x 480 pixels")


@pytest.fixture(scope="module")
def observation() -> Observation:
    pytest.importorskip("mujoco")
    from blockstab.simulation.simulated import Recipe, simulate_scene

    frame, _ = simulate_scene(Recipe("objects", SEED), 3)
    return observe(frame, estimated_ground)


@pytest.fixture(scope="module")
def views(observation: Observation) -> Views:
    return view(observation)


@pytest.fixture(scope="module")
def merging() -> Silberman:
    return silberman()


def test_boundaries_and_their_watershed(benchmark: BenchmarkFixture, observation: Observation) -> None:
    def basins() -> Tensor:
        return over_segment(FixedWeights()(cues_of(observation.frame)).strength, observation.cloud.valid)

    assert int(benchmark(basins).max()) > 10


def test_color_gradients(benchmark: BenchmarkFixture, observation: Observation) -> None:
    assert benchmark(color_gradients, observation.frame.color).shape == (4, 4, 480, 640)


def test_relief(benchmark: BenchmarkFixture, observation: Observation) -> None:
    assert benchmark(relief, observation.frame).shape == (3, 4, 480, 640)


def test_cues(benchmark: BenchmarkFixture, observation: Observation) -> None:
    benchmark(cues_of, observation.frame)


def test_combination(benchmark: BenchmarkFixture, observation: Observation) -> None:
    benchmark(FixedWeights(), cues_of(observation.frame))


def test_planes(benchmark: BenchmarkFixture, observation: Observation) -> None:
    benchmark(find_planes, observation.cloud)


def test_atoms(benchmark: BenchmarkFixture, observation: Observation) -> None:
    benchmark(
        over_segment, observation.boundary_map.strength, observation.cloud.valid, observation.planes.label
    )


def test_hierarchy(benchmark: BenchmarkFixture, observation: Observation) -> None:
    benchmark(lambda: build_hierarchy(make_atoms(observation.fine, observation.boundary_map.strength)))


def test_edgelets(benchmark: BenchmarkFixture, observation: Observation) -> None:
    benchmark(trace_edgelets, observation.fine)


def test_views(benchmark: BenchmarkFixture, observation: Observation) -> None:
    benchmark(view, observation)


def test_appearance_of_the_atoms(benchmark: BenchmarkFixture, observation: Observation, views: Views) -> None:
    edgelets = trace_edgelets(observation.fine)

    def rows() -> Tensor:
        return edgelet_appearance(viewed_regions(views, observation.fine), edgelets, observation.boundary_map)

    assert benchmark(rows).shape == (len(edgelets), 51)


def test_merging_in_five_stages(
    benchmark: BenchmarkFixture, observation: Observation, merging: Silberman
) -> None:
    assert int(benchmark(merging, observation).label.max()) > 1


def test_all(benchmark: BenchmarkFixture, observation: Observation, merging: Silberman) -> None:
    benchmark(lambda: merging(observe(observation.frame, estimated_ground)))


def test_points_and_normals(benchmark: BenchmarkFixture, observation: Observation) -> None:
    benchmark(cloud_from_frame, observation.frame)


@pytest.mark.parametrize("method", ["watershed", "slic", "felzenszwalb"])
def test_scikit_image(benchmark: BenchmarkFixture, observation: Observation, method: str) -> None:
    color = observation.frame.color.numpy()
    methods: dict[str, Callable[[], np.ndarray]] = {
        "watershed": lambda: watershed(sobel(rgb2gray(color)), markers=PARTS),
        "slic": lambda: slic(color, n_segments=PARTS),
        "felzenszwalb": lambda: felzenszwalb(color, scale=200, sigma=1.0, min_size=25),
    }
    assert int(benchmark(methods[method]).max()) > 10
