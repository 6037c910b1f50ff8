"""Felzenszwalb's regions on colour, normals and depth."""

from __future__ import annotations

import warnings

import pytest

from blockstab.proposals.felzenszwalb import Felzenszwalb
from tests.block_scene import APART, picture


def test_pixels_without_depth_belong_to_no_region() -> None:
    scene = picture(APART)
    scene.frame.depth[50:80, 200:240] = 0.0
    scene.cloud.valid[50:80, 200:240] = False
    label = Felzenszwalb()(scene.observation).label
    assert ((label > 0) == scene.cloud.valid).all()


def test_a_larger_scale_gives_fewer_regions() -> None:
    scene = picture(APART)
    counts = [len(Felzenszwalb(scale)(scene.observation).label.unique()) for scale in (10.0, 10000.0)]
    assert counts[0] > counts[1]


def test_it_runs_without_a_warning() -> None:
    scene = picture(APART)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        Felzenszwalb()(scene.observation)


@pytest.mark.parametrize("wrong", [{"scale": 0.0}, {"depth_m": -1.0}])
def test_settings_must_be_above_zero(wrong: dict[str, float]) -> None:
    with pytest.raises(ValueError, match="above 0"):
        Felzenszwalb(**wrong)
