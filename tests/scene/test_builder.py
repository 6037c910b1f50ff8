"""Photographs understood: supports and stability as worked by hand, whatever else is understood with them."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import fields, is_dataclass, replace

import pytest
import torch
from torch import Tensor

from blockstab.boxes.background import BackgroundRules
from blockstab.geometry.convex_hulls import Polygons
from blockstab.observation import given_ground, observe
from blockstab.proposals.search_input import SearchInput, make_search_input
from blockstab.proposals.watershed import Watershed
from blockstab.scene.builder import SceneBuilder
from blockstab.scene.inference import Rules
from blockstab.scene.types import Scene
from blockstab.segments.segmentation import Segmentation
from blockstab.stability.judges import EverySupport
from blockstab.stability.support import GROUND, SupportType, tilt
from blockstab.testing.photographs import BLOCKS, TABLE_Y, Photograph, photograph
from blockstab.testing.worlds import Block
from tests.synthetic import builder, over_split, variants, view_of
from tests.tolerance import COMPANY

MM = 1e-3
# A plank of 0.3 m that leans at 30 degrees to the vertical on a block on its left.
_FOOT = 0.1 - 0.01 - 0.3 * math.sin(math.radians(30))
LEANING = (Block(0.1, 0, 0.02, 0.3, d=0.12, tilt_deg=30), Block(_FOOT - 0.04, 0, 0.08, 0.26, d=0.16))


def understood(photo: Photograph, rules: Rules | None = None) -> tuple[Scene, list[int]]:
    """The true segments understood, and the label of each."""
    search_input = view_of(photo)
    (scene,) = builder(search_input, rules)([search_input.start])
    return scene, labels_of(search_input, scene.segmentation)


def labels_of(search_input: SearchInput, segmentation: Segmentation) -> list[int]:
    inside = [(search_input.atoms.label - 1 == min(segment)) for segment in segmentation.segments]
    return [int(search_input.label[place].mode().values) for place in inside]


def supports(photo: Photograph, rules: Rules | None = None) -> set[tuple[int, int, str]]:
    """(supporter, supported, type in lower case) by label; 0 is the ground."""
    scene, labels = understood(photo, rules)
    name = {GROUND: 0, **dict(enumerate(labels))}
    columns = (scene.supports.supporter, scene.supports.supported, scene.supports.type)
    rows = zip(*(column.tolist() for column in columns), strict=True)
    return {(name[a], name[b], SupportType(kind).name.lower()) for a, b, kind in rows}


def untold(segmentation: Segmentation) -> Segmentation:
    """The same segments, of which nobody has told anything."""
    return Segmentation(segmentation.segments)


def tilts_deg(scene: Scene) -> Tensor:
    return torch.rad2deg(tilt(scene.boxes.rotation.transpose(1, 2)).amin(dim=1))


def test_boxes_are_where_the_blocks_are():
    photo = photograph(*BLOCKS)
    scene, labels = understood(photo)
    for label in (2, 3, 4):  # of the fifth, the foot is hidden
        box, truth = scene.boxes[[labels.index(label)]], photo.boxes[[label - 2]]
        assert float((box.center - truth.center).norm()) < 4 * MM
        half = box.half_extent.sort(dim=1).values - truth.half_extent.sort(dim=1).values
        assert float(half.abs().amax()) < 4 * MM


def test_the_supports_of_a_tower_and_its_neighbours():
    assert supports(photograph(*BLOCKS)) == {
        (0, 2, "surface"), (2, 3, "surface"), (0, 4, "surface"), (0, 5, "surface"),
    }  # fmt: skip


def test_what_stands_is_stable_and_its_margin_is_the_way_to_the_edge():
    scene, labels = understood(photograph(*BLOCKS))
    assert bool(scene.balance.stable.all())
    margin = dict(zip(labels, scene.balance.margin.tolist(), strict=True))
    assert margin.pop(1) == math.inf  # the table
    assert [margin[label] for label in (2, 3, 4, 5)] == pytest.approx([0.06, 0.05, 0.05, 0.04], abs=3 * MM)


def test_what_hangs_over_too_far_is_unstable_and_topples():
    scene, labels = understood(photograph(Block(0, 0, 0.12, 0.1, d=0.12), Block(0.1, 0.1, 0.16, 0.06, d=0.1)))
    verdict = dict(zip(labels, scene.balance.stable.tolist(), strict=True))
    assert verdict == {1: True, 2: True, 3: False}
    assert float(scene.balance.margin[labels.index(3)]) == pytest.approx(-0.04, abs=3 * MM)


def test_the_table_is_background_and_stands_for_the_ground():
    scene, labels = understood(photograph(*BLOCKS))
    assert scene.background.tolist() == [label == 1 for label in labels]
    table = labels.index(1)
    assert table not in scene.supports.supporter.tolist()
    assert table not in scene.supports.supported.tolist()


def test_background_is_told_from_the_shape_where_nothing_is_known():
    search_input = view_of(photograph(*BLOCKS), Watershed())
    (scene,) = builder(search_input)([untold(search_input.start)])
    assert int(scene.background.sum()) == 1
    assert int(scene.pixel_count[scene.background]) == int(scene.pixel_count.max())


def test_what_is_known_of_a_segment_counts_more_than_its_shape():
    photo = photograph(*BLOCKS)
    odd = replace(photo, frame=replace(photo.frame, background_ids=(4,)))
    scene, labels = understood(odd)
    assert scene.background.tolist() == [label == 4 for label in labels]


def test_the_same_segments_are_understood_by_what_is_told_of_them_whatever_came_before():
    search_input = view_of(photograph(*BLOCKS))
    lower = search_input.start.segments[labels_of(search_input, search_input.start).index(2)]
    wall = search_input.start.telling({lower: True})
    build = builder(search_input)
    before, told, after = (build([one])[0] for one in (search_input.start, wall, search_input.start))
    (alone,) = builder(search_input)([wall])
    place = search_input.start.segments.index(lower)
    assert told.background.tolist() == [b or k == place for k, b in enumerate(before.background.tolist())]
    assert place not in told.supports.supported.tolist()
    assert place in told.supports.supporter.tolist()  # it still bears what stands on it
    assert _differences(before, after) == _differences(told, alone) == []
    assert _differences(before, told) != []


@pytest.mark.parametrize("noise", [5e-4, 1.5e-3])
def test_boxes_that_stand_on_the_ground_become_upright(noise):
    photo = photograph(*BLOCKS, noise=noise)
    as_fitted, _ = understood(photo, Rules(refit_rounds=0))
    refitted, labels = understood(photo)
    objects = torch.tensor([label != 1 for label in labels])
    assert float(tilts_deg(as_fitted)[objects].amax()) > 0.01
    assert float(tilts_deg(refitted)[objects].amax()) < 1e-5


@pytest.mark.parametrize("slant", [-0.12, 0.12])
def test_a_box_tilted_by_noise_is_made_flat_by_what_it_stands_on(slant):
    # Depth that drifts over the upper block tilts what is seen of it, as in Fig. 10.
    photo = photograph(*BLOCKS)
    rows = torch.arange(len(photo.frame.depth), dtype=torch.float64)[:, None].expand_as(photo.frame.depth)
    upper = photo.frame.label == 3
    drift = slant * (rows - rows[upper].mean()) / 260.0 * upper
    odd = replace(photo, frame=replace(photo.frame, depth=photo.frame.depth * (1 + drift)))
    as_fitted, labels = understood(odd, Rules(refit_rounds=0))
    refitted, _ = understood(odd)
    assert float(tilts_deg(as_fitted)[labels.index(3)]) > 2.0
    assert float(tilts_deg(refitted)[labels.index(3)]) < 1e-5
    assert bool(refitted.balance.stable.all())


@pytest.mark.parametrize("turn_deg", [25.0, -25.0, 10.0])
def test_a_plank_that_truly_leans_is_left_alone(turn_deg):
    photo = photograph(*LEANING, turn_deg=turn_deg)
    assert supports(photo) == {(0, 2, "partial"), (3, 2, "side"), (0, 3, "surface")}
    scene, labels = understood(photo)
    assert float(tilts_deg(scene)[labels.index(2)]) == pytest.approx(30.0, abs=0.5)
    assert bool(scene.balance.stable.all())
    before, _ = understood(photo, Rules(refit_rounds=0))
    plank = labels.index(2)
    assert torch.equal(before.boxes.center[plank], scene.boxes.center[plank])


def test_without_trimming_every_nearness_counts():
    photo = photograph(Block(0, 0, 0.1, 0.14), Block(0.11, 0, 0.1, 0.1))
    assert supports(photo) == {(0, 2, "surface"), (0, 3, "surface")}
    every = supports(photo, Rules(judge=EverySupport()))
    assert every == {(0, 2, "surface"), (0, 3, "surface"), (2, 3, "side"), (3, 2, "side")}


def test_a_box_whose_foot_is_hidden_reaches_down_to_the_table():
    # Alone it would float: the block before it hides all but its upper part.
    photo = photograph(Block(0, 0, 0.4, 0.12, z=0.1, d=0.06), Block(0, 0, 0.1, 0.2, z=-0.02), turn_deg=0.0)
    short, labels = understood(photo, Rules(refit_rounds=0))
    scene, _ = understood(photo)
    hidden = labels.index(3)
    assert float(short.boxes.corners()[hidden, :, 1].amin()) > TABLE_Y + 0.03
    assert float(scene.boxes.corners()[hidden, :, 1].amin()) == pytest.approx(TABLE_Y, abs=3 * MM)
    assert (0, 3, "surface") in supports(photo)


def test_without_a_ground_the_lowest_points_bear():
    search_input = view_of(photograph(*BLOCKS))
    ground = replace(search_input.observation.ground, height=None)
    adrift = replace(search_input, observation=replace(search_input.observation, ground=ground))
    (scene,) = builder(adrift)([search_input.start])
    assert bool((scene.supports.supporter == GROUND).any())


@pytest.mark.parametrize("degrees", [0.0, 50.0, 200.0])
def test_turning_the_world_about_the_vertical_turns_the_boxes_and_changes_no_verdict(degrees):
    search_input = view_of(photograph(*BLOCKS))
    cos, sin = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
    turn = torch.tensor([[cos, 0.0, sin], [0.0, 1.0, 0.0], [-sin, 0.0, cos]], dtype=torch.float64)
    observation = search_input.observation
    ground = replace(observation.ground, world_from_camera=turn @ observation.ground.world_from_camera)
    turned = replace(
        search_input, observation=replace(observation, cloud=observation.cloud.rotated(turn), ground=ground)
    )
    (before,), (after,) = builder(search_input)([search_input.start]), builder(turned)([search_input.start])
    torch.testing.assert_close(after.boxes.center, before.boxes.rotated(turn).center, rtol=0.0, atol=1e-6)
    assert after.supports.supporter.tolist() == before.supports.supporter.tolist()
    assert after.balance.stable.tolist() == before.balance.stable.tolist()


def test_a_batch_gives_the_same_scenes_within_1e_9_as_one_by_one():
    search_input = view_of(photograph(*BLOCKS))
    many, grown = variants(search_input, 24), builder(search_input)
    together = builder(search_input)(many)
    for order, others in {
        "backwards": builder(search_input)(many[::-1])[::-1],
        "in turn": [grown([one])[0] for one in many],
        "each anew": [builder(search_input)([one])[0] for one in many],
    }.items():
        for one, scene, other in zip(many, together, others, strict=True):
            assert other.segmentation == scene.segmentation == one
            assert _differences(scene, other) == [], order


def test_no_segmentation_gives_no_scene():
    assert builder(view_of(photograph(*BLOCKS)))([]) == []


def test_what_was_understood_once_costs_nothing_more():
    search_input = view_of(photograph(*BLOCKS))
    build = builder(search_input)
    build([search_input.start])
    fits = len(build.box_cache)
    (again,) = build([search_input.start])
    assert len(build.box_cache) == fits
    assert again.segmentation == search_input.start


def test_a_move_costs_the_box_that_is_new_and_re_fits_about_it():
    search_input = view_of(photograph(*BLOCKS))
    build = builder(search_input)
    start = over_split(search_input)
    (scene,) = build([start])
    before = len(build.box_cache)
    first, second = start.neighbours(search_input.atoms)
    objects = ~scene.background[first] & ~scene.background[second]
    build([start.merge(int(first[objects][0]), int(second[objects][0]))])
    # The new box, free and to an axis or two; those above it may follow it.
    assert before + 1 <= len(build.box_cache) <= before + 8


def test_an_atom_without_depth_is_refused():
    search_input = view_of(photograph(*BLOCKS))
    hole = search_input.atoms.label == 3
    cloud = replace(search_input.observation.cloud, valid=search_input.observation.cloud.valid & ~hole)
    with pytest.raises(ValueError, match="Atom 3 holds no pixel with depth"):
        SceneBuilder(
            cloud, search_input.occlusion, search_input.observation.ground, search_input.atoms, Rules()
        )


def test_the_thresholds_of_background_are_those_given():
    photo = photograph(*BLOCKS)
    search_input = make_search_input(observe(photo.frame, given_ground), Watershed())
    nothing = Rules(background=BackgroundRules(plane_share=1.1))
    assert not bool(builder(search_input, nothing)([untold(search_input.start)])[0].background.any())


def _differences(one: object, other: object, path: str = "scene") -> list[str]:
    """Where two values differ by more than company may; places past the vertices of a polygon do not count."""
    return [
        name
        for (name, a), (_, b) in zip(_tensors(one, path), _tensors(other, path), strict=True)
        if a.shape != b.shape or not torch.allclose(a, b, rtol=0.0, atol=COMPANY, equal_nan=True)
    ]


def _tensors(value: object, path: str) -> Iterator[tuple[str, Tensor]]:
    if isinstance(value, Tensor):
        yield path, value
    elif isinstance(value, Polygons):
        yield f"{path}.count", value.count
        place = torch.arange(value.vertices.shape[1]) < value.count[:, None]
        yield f"{path}.vertices", value.vertices[place]
    elif is_dataclass(value):
        for field in fields(value):
            yield from _tensors(getattr(value, field.name), f"{path}.{field.name}")
