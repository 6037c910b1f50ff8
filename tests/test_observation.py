"""What an image shows, where the sensor sees nothing too."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import pytest
import torch

from blockstab.boundaries.cues import CUES, cues_of
from blockstab.observation import Observation, given_ground, observe
from blockstab.proposals.files import LabelFile
from blockstab.proposals.search_input import make_search_input
from blockstab.rgbd.frame import Frame
from blockstab.rgbd.noise import KINECT
from blockstab.segments.pieces import connected_pieces
from blockstab.testing.photographs import photograph
from blockstab.testing.worlds import Block

SCREEN = Block(0, 0, 0.26, 0.2, d=0.04)
FRAME_PX = 4  # the width of the screen's frame, which the sensor sees


@cache
def screen(band_px: int) -> Frame:
    """A box whose face is too black for the sensor, but for a band of that width along its border."""
    frame = photograph(SCREEN, turn_deg=0.0).frame
    assert frame.label is not None
    inside = frame.label == 2
    for _ in range(band_px):
        inside = -torch.nn.functional.max_pool2d(-inside[None].double(), 3, 1, 1)[0] > 0.5
    return replace(frame, depth=torch.where(inside, 0.0, frame.depth))


@cache
def seen(band_px: int) -> Observation:
    return observe(screen(band_px), given_ground)


def test_a_black_screen_is_filled_by_the_parts_around_it():
    frame, observation = screen(FRAME_PX), seen(FRAME_PX)
    hole = (frame.depth == 0) & (frame.label == 2)
    assert int(hole.sum()) > 2500
    assert float((observation.fine[hole] > 0).double().mean()) > 0.9


def test_the_parts_that_fill_it_are_those_of_the_screen():
    frame, observation = screen(FRAME_PX), seen(FRAME_PX)
    hole = (frame.depth == 0) & (frame.label == 2) & (observation.fine > 0)
    for part in observation.fine[hole].unique().tolist():
        around = (observation.fine == part) & (frame.depth > 0)
        assert bool(around.any())  # every part has measured pixels
        assert float((frame.label[around] == 2).double().mean()) > 0.5


def test_parts_hang_together_after_they_have_grown():
    fine = seen(FRAME_PX).fine
    assert int(connected_pieces(fine).max()) == int(fine.max()) == len(fine.unique()) - int((fine == 0).any())


def test_the_screen_is_a_whole_segment_of_its_label():
    frame = screen(FRAME_PX)
    search_input = make_search_input(seen(FRAME_PX), LabelFile())
    (block,) = (s for s in search_input.start.segments if not search_input.start.background[s])
    covered = torch.isin(search_input.atoms.label - 1, torch.tensor(sorted(block)))
    assert float((covered & (frame.label == 2)).sum() / (frame.label == 2).sum()) > 0.9


def test_a_shadow_never_goes_to_the_thing_that_casts_it():
    frame = photograph(Block(0, 0, 0.2, 0.2, d=0.2), turn_deg=0.0, noise=0.0).frame
    assert frame.label is not None
    thing = frame.label == 2
    columns = torch.arange(thing.shape[1]).expand_as(thing)
    left = torch.where(thing, columns, 10**6).amin(dim=1, keepdim=True)
    shadow = (columns >= left - 6) & (columns < left)
    shadow &= (
        torch.arange(len(thing))[:, None] < 70
    )  # below, at its foot, the thing is as far away as the ground
    fine = observe(replace(frame, depth=torch.where(shadow, 0.0, frame.depth)), given_ground).fine
    assert int(shadow.sum()) > 200
    for row, column in shadow.nonzero().tolist():
        assert fine[row, column] == fine[row, int(left[row]) - 7] > 0


def test_without_gaps_nothing_is_flooded():
    full = photograph(SCREEN, turn_deg=0.0).frame
    observation = observe(full, given_ground)
    assert torch.equal(observation.fine > 0, observation.cloud.valid)


def test_signs_are_the_cues_whichever_way_they_run():
    frame = photograph(SCREEN).frame
    observation, cues = observe(frame, given_ground), cues_of(frame)
    assert observation.cues.shape == (len(CUES), *frame.depth.shape)
    assert observation.cues.dtype == torch.float32
    for name, sign in zip(CUES, observation.cues, strict=True):
        assert torch.equal(sign, cues[name].amax(dim=0))


def test_the_ground_is_what_lies_flat_in_its_plane_and_the_foot_of_a_block_is_not():
    frame = photograph(Block(0, 0, 0.12, 0.1, d=0.12), noise=0.0).frame
    observation = observe(frame, given_ground)
    assert float(observation.on_ground[frame.label == 1].double().mean()) > 0.97
    assert float(observation.on_ground[frame.label == 2].double().mean()) < 0.06


@pytest.mark.parametrize("height", [None, 5.0])
def test_where_the_ground_is_unknown_or_far_nothing_lies_in_it(height):
    observation = seen(FRAME_PX)
    moved = replace(observation, ground=replace(observation.ground, height=height))
    assert not bool(moved.on_ground.any())


def test_what_has_no_depth_does_not_lie_in_the_ground():
    observation = seen(FRAME_PX)
    assert not bool((observation.on_ground & ~observation.cloud.valid).any())
    height = (observation.cloud.points[..., 1] - observation.ground.height).abs()
    step = KINECT.step * observation.cloud.depth**2
    assert bool((height[observation.on_ground] < (2 * step).clamp(min=0.01)[observation.on_ground]).all())
