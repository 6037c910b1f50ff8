"""What is said of simulated scenes is true."""

from __future__ import annotations

import pytest
import torch

from blockstab.boxes.box import Boxes, checked
from blockstab.boxes.separation import separation
from blockstab.datasets.truth import Truth
from blockstab.rgbd.cloud import cloud_from_frame
from blockstab.rgbd.frame import Frame
from blockstab.simulation.physics.settling import moves
from blockstab.simulation.sensors.kinect import axial_noise
from blockstab.simulation.simulated import Recipe, simulate_scene
from tests.simulation.scenery import pile_of_boxes

pytest.importorskip("mujoco", reason="the extra `sim` is not installed")

TOUCH = 0.001  # metres; how far contacts sink in, or stay apart, in the engine
Scenes = list[tuple[Frame, Truth]]


def boxes_of(truth: Truth) -> Boxes:
    poses = torch.stack([o.pose_camera for o in truth.objects if o.pose_camera is not None])
    half_extents = torch.stack([o.half_extent for o in truth.objects if o.half_extent is not None])
    return checked(Boxes(poses[:, :3, 3], poses[:, :3, :3], half_extents))


def up_of(truth: Truth) -> torch.Tensor:
    assert truth.up_camera is not None
    return truth.up_camera


def label_of(frame: Frame) -> torch.Tensor:
    assert frame.label is not None
    return frame.label


def test_every_supporter_touches_what_it_supports(scenes: Scenes) -> None:
    for _, truth in scenes:
        pairs = [(i, s - 2) for i, o in enumerate(truth.objects) for s in o.supported_by or () if s != 1]
        upper, lower = torch.tensor(pairs).unbind(dim=1)
        assert float(separation(boxes_of(truth), lower, upper).gap.abs().max()) < TOUCH


def test_every_object_has_a_supporter_and_a_third_stand_on_another(scenes: Scenes) -> None:
    supporters = [o.supported_by for _, truth in scenes for o in truth.objects]
    assert all(supporters)
    for _, truth in scenes:
        stacked = [any(s != 1 for s in o.supported_by or ()) for o in truth.objects]
        assert 3 * sum(stacked) >= len(stacked)
        assert 3 <= len(stacked) <= 14


def test_what_the_table_supports_stands_on_one_plane_and_nothing_reaches_below_it(scenes: Scenes) -> None:
    for _, truth in scenes:
        lowest = (boxes_of(truth).corners() @ up_of(truth)).amin(dim=1)
        on_table = torch.tensor([1 in (o.supported_by or ()) for o in truth.objects])
        assert float(lowest[on_table].amax() - lowest.amin()) < TOUCH
        assert (lowest[~on_table] > lowest[on_table].amin() + 0.02).all()


def test_up_is_the_normal_of_the_table_that_the_sensor_measures(scenes: Scenes) -> None:
    for frame, truth in scenes:
        table = cloud_from_frame(frame).points[(label_of(frame) == 1) & (frame.depth < 2.0)]
        heights = table @ up_of(truth)
        assert float((heights - heights.median()).abs().quantile(0.9)) < 0.01
        lowest = (boxes_of(truth).corners() @ up_of(truth)).amin()
        assert abs(float(heights.median() - lowest)) < 0.002


def test_measured_points_lie_on_the_true_boxes_within_the_noise(scenes: Scenes) -> None:
    for frame, truth in scenes:
        points = cloud_from_frame(frame).points
        boxes = boxes_of(truth)
        for i, o in enumerate(truth.objects):
            mine = (label_of(frame) == o.id) & (frame.depth > 0)
            if int(mine.sum()) < 300:
                continue
            local = boxes[[i]].local(points[mine][None])[0]
            # Where a point is outside, the largest excess bounds its distance to the surface from below.
            off = (local.abs() - boxes.half_extent[i]).amax(dim=1)
            noise = axial_noise(frame.depth[mine], torch.tensor(1.0, dtype=torch.float64))
            assert float((off.abs() / noise).quantile(0.8)) < 2.5
            assert abs(float(off.median())) < 0.0015


def test_labels_are_the_background_and_the_objects_where_depth_is_missing_too(scenes: Scenes) -> None:
    for frame, truth in scenes:
        label = label_of(frame)
        known = {0, *truth.background_ids, *(o.id for o in truth.objects)}
        assert set(label.unique().tolist()) <= known
        assert frame.background_ids == truth.background_ids
        assert bool((label[frame.depth > 0] > 0).all())
        assert label[frame.depth == 0].any()
        assert float((frame.depth == 0).double().mean()) < 0.6


def test_what_rests_on_one_thing_alone_falls_without_it(scenes: Scenes) -> None:
    for _, truth in scenes:
        falling = {o.id: o.falls_if_removed or () for o in truth.objects}
        for o in truth.objects:
            assert o.supported_by
            if len(o.supported_by) == 1 and o.supported_by != (1,):
                assert o.id in falling[o.supported_by[0]]


def test_what_is_let_go_where_the_truth_says_stays_there(scenes: Scenes) -> None:
    for _, truth in scenes:
        boxes, up = boxes_of(truth), up_of(truth)
        right = torch.linalg.cross(up, torch.eye(3, dtype=torch.float64)[2])
        right = right / right.norm()
        level = torch.stack([right, up, torch.linalg.cross(right, up)])
        standing = boxes.rotated(level)
        floor = standing.corners()[..., 1].amin()
        shift = torch.stack([-standing.center[:, 0].mean(), -floor, -standing.center[:, 2].mean()])
        pile = pile_of_boxes(Boxes(standing.center + shift, standing.rotation, standing.half_extent))
        assert not moves(pile).any()


def test_the_boundary_is_where_labels_differ(scenes: Scenes) -> None:
    for frame, truth in scenes:
        assert truth.boundary is not None
        label = label_of(frame)
        assert torch.equal(truth.boundary[0][:, :-1], label[:, :-1] != label[:, 1:])
        assert torch.equal(truth.boundary[1][:-1], label[:-1] != label[1:])
        assert not truth.boundary[0][:, -1].any()
        assert not truth.boundary[1][-1].any()


def test_an_object_covers_at_least_the_pixels_that_are_seen_of_it(scenes: Scenes) -> None:
    for frame, truth in scenes:
        for o in truth.objects:
            own = label_of(frame) == o.id
            assert o.total_pixels is not None
            assert o.total_pixels >= int(own.sum())
            assert o.hardly_seen == (int((own & (frame.depth > 0)).sum()) < 100)


def test_each_supporter_has_a_type_and_an_upright_block_on_the_table_lies_on_a_surface(
    scenes: Scenes,
) -> None:
    upright = 0
    for _, truth in scenes:
        for o in truth.objects:
            assert o.support_types is not None
            assert len(o.support_types) == len(o.supported_by or ())
            assert o.pose_camera is not None
            flat = float((up_of(truth) @ o.pose_camera[:3, :3]).abs().max()) > 0.99999
            if flat and o.supported_by == (1,):
                upright += 1
                assert o.support_types == ("surface",)
    assert upright > 5


@pytest.mark.parametrize("preset", ["objects", "grocery", "desk"])
def test_the_other_presets_have_the_same_truth(preset: str) -> None:
    frame, truth = simulate_scene(Recipe(preset, 2), 0)
    assert {o.id for o in truth.objects} == set(range(2, len(truth.objects) + 2))
    assert all(o.supported_by for o in truth.objects)
    assert len({o.kind for o in truth.objects}) > 1
    assert set(label_of(frame).unique().tolist()) <= {
        0,
        *truth.background_ids,
        *(o.id for o in truth.objects),
    }


@pytest.mark.parametrize("sensor", ["realsense", "ideal"])
def test_another_sensor_sees_the_same_pile(sensor: str, scenes: Scenes) -> None:
    frame, truth = simulate_scene(Recipe("blocks", 4, sensor), 0)
    other = scenes[0][1]
    assert [o.supported_by for o in truth.objects] == [o.supported_by for o in other.objects]
    assert [o.half_extent.tolist() for o in truth.objects if o.half_extent is not None] == [
        o.half_extent.tolist() for o in other.objects if o.half_extent is not None
    ]
    assert not torch.equal(frame.depth, scenes[0][0].depth)


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"preset": "cubes"}, "no preset 'cubes'; choose from: blocks, objects, grocery"),
        ({"sensor": "eyes"}, "no sensor 'eyes'; choose from: "),
        ({"seed": -1}, "must not be negative, but is -1"),
        ({"variety": 1.5}, "between 0 and 1, but is 1.5"),
        ({"variety": float("nan")}, "between 0 and 1, but is nan"),
    ],
)
def test_a_recipe_that_cannot_be_is_refused(settings: dict[str, object], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        Recipe(**settings)  # type: ignore[arg-type]
