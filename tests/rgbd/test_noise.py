"""Noise of depth, and what grows with it."""

from __future__ import annotations

import json
from dataclasses import replace

import pytest
import torch

from blockstab.datasets.folder import write_scene
from blockstab.datasets.truth import Truth
from blockstab.observation import estimated_ground, observe
from blockstab.rgbd.frame import FrameError, read_scene
from blockstab.rgbd.noise import IDEAL, KINECT, NOISES, REALSENSE, DepthNoise, noise_from
from blockstab.scene.inference import Rules
from blockstab.segments.shadows import shadows
from blockstab.testing.photographs import BLOCKS, photograph

FRAME = photograph(*BLOCKS).frame
TRUTH = Truth((1,), (), None, False)


def seen_by(noise):
    return replace(FRAME, camera=replace(FRAME.camera, noise=noise))


@pytest.mark.parametrize("noise", [*NOISES.values(), DepthNoise(1e-3, 2e-3, 0.2)])
def test_a_scene_folder_keeps_the_noise_of_its_camera(tmp_path, noise):
    write_scene(tmp_path / "a", seen_by(noise), TRUTH, {})
    assert read_scene(tmp_path / "a").camera == seen_by(noise).camera
    said = json.loads((tmp_path / "a" / "meta.json").read_text())
    assert ("depth_noise" in said) == (noise != KINECT)


@pytest.mark.parametrize("name", NOISES)
def test_a_scene_may_name_its_sensor(tmp_path, name):
    write_scene(tmp_path / "a", FRAME, TRUTH, {})
    path = tmp_path / "a" / "meta.json"
    path.write_text(json.dumps({**json.loads(path.read_text()), "depth_noise": name}))
    assert read_scene(tmp_path / "a").camera.noise == NOISES[name]


@pytest.mark.parametrize(
    ("said", "why"),
    [
        ("kinekt", "one of kinect, realsense, ideal"),
        (3, "one of kinect"),
        ({"step": "0.1"}, "one of kinect"),
        ({"step": 0.0}, "above 0"),
        ({"baseline_m": -0.1}, "baseline from 0"),
        ({"stepp": 0.1}, "stepp"),
    ],
)
def test_noise_that_is_none_is_refused_in_one_line_that_names_the_file(tmp_path, said, why):
    with pytest.raises(ValueError, match=why):
        noise_from(said)
    write_scene(tmp_path / "a", FRAME, TRUTH, {})
    path = tmp_path / "a" / "meta.json"
    path.write_text(json.dumps({**json.loads(path.read_text()), "depth_noise": said}))
    with pytest.raises(FrameError, match=r"meta\.json: depth_noise") as caught:
        read_scene(tmp_path / "a")
    assert "\n" not in str(caught.value)


def test_rules_for_a_kinect_are_those_that_are_stated():
    assert Rules().under(KINECT) == Rules()


def test_thresholds_that_grow_with_distance_grow_with_the_step_and_the_others_stay():
    rules, twice = Rules(), Rules().under(DepthNoise(step=2 * KINECT.step))
    assert twice.support.touch_per_square_m == 2 * rules.support.touch_per_square_m
    assert twice.background.plane_per_square_m == 2 * rules.background.plane_per_square_m
    assert twice.fitter.tolerance.per_square_m == 2 * rules.fitter.tolerance.per_square_m
    assert twice.support.touch_m == rules.support.touch_m
    assert twice.fitter.tolerance.floor_m == rules.fitter.tolerance.floor_m


def test_points_know_the_noise_of_their_camera_and_keep_it_when_turned():
    cloud = observe(seen_by(REALSENSE), estimated_ground).cloud
    assert cloud.noise == REALSENSE


def test_a_coarser_sensor_takes_more_for_ground():
    counts = [
        int(observe(seen_by(noise), estimated_ground).on_ground.sum())
        for noise in (KINECT, DepthNoise(step=8 * KINECT.step))
    ]
    assert counts[0] < counts[1]


def test_eyes_further_apart_cast_wider_shadows():
    depth = torch.cat(
        [torch.full((1, 40), 0.8), torch.zeros(1, 20), torch.full((1, 40), 1.2)], dim=1
    ).double()
    wide, narrow = ((shadows(depth, 525.0, noise.baseline_m) >= 0).any() for noise in (KINECT, IDEAL))
    assert bool(wide)
    assert not bool(narrow)
