"""From a frame to everything a parse gives."""

from __future__ import annotations

from dataclasses import replace
from functools import partial

import jsonschema
import numpy as np
import pytest
import torch
from PIL import Image

from blockstab.energy.overlap import TwoJudges, expected_overlap
from blockstab.observation import estimated_ground, given_ground, observe
from blockstab.output.export import scene_record, scene_schema, write_parsed
from blockstab.parsing.parsed import Parsed
from blockstab.parsing.parser import Parser
from blockstab.proposals import Proposed
from blockstab.proposals.felzenszwalb import Felzenszwalb
from blockstab.proposals.files import LabelFile
from blockstab.proposals.search_input import make_search_input
from blockstab.proposals.watershed import Watershed
from blockstab.rgbd.frame import Frame
from blockstab.search.greedy import Greedy
from blockstab.search.none import NoSearch
from blockstab.search.rsamp import RSamp
from blockstab.testing.photographs import BLOCKS, photograph
from tests.tolerance import EXACT
from tests.toy_potentials import toy_potentials

AS_IT_IS = Parser(LabelFile(), NoSearch(), toy_potentials())
RECKLESS = partial(expected_overlap, caution=0.0, turning=0.0)
SAMPLED = Parser(Watershed(threshold=0.3, least_px=60), RSamp(rounds=3), toy_potentials(), energy=RECKLESS)


@pytest.fixture(scope="module")
def frame() -> Frame:
    return photograph(*BLOCKS).frame


@pytest.fixture(scope="module")
def given(frame) -> Parsed:
    """The folder's own labels, understood."""
    return AS_IT_IS(frame)


@pytest.fixture(scope="module")
def sampled(frame) -> Parsed:
    """The whole path, from the image alone."""
    return SAMPLED(replace(frame, label=None))


def by_id(parsed: Parsed) -> dict[int, dict]:
    return {segment["id"]: segment for segment in scene_record(parsed)["segments"]}


def test_given_labels_keep_their_ids_and_their_pixels(frame, given):
    assert sorted(given.ids) == [1, 2, 3, 4, 5]
    assert torch.equal(given.label, frame.label)


@pytest.mark.parametrize("ids", [(7, 300, 2, 40000, 9), (65535, 1, 2, 3, 4)])
def test_ids_carry_no_order(frame, ids):
    renamed = torch.tensor([0, *ids])[frame.label]
    parsed = AS_IT_IS(replace(frame, label=renamed, background_ids=(ids[0],)))
    assert torch.equal(parsed.label, renamed)
    assert [i for i, s in by_id(parsed).items() if s["background"]] == [ids[0]]


def test_background_ids_are_background(frame):
    assert [i for i, s in by_id(AS_IT_IS(frame)).items() if s["background"]] == [1]
    odd = AS_IT_IS(replace(frame, background_ids=(1, 5)))
    assert sorted(i for i, s in by_id(odd).items() if s["background"]) == [1, 5]


def test_the_supports_and_falls_of_the_tower(given):
    record = scene_record(given)
    supports = {(s["supporter"], s["supported"]) for s in record["supports"]}
    assert supports == {(0, 2), (2, 3), (0, 4), (0, 5)}
    assert {i: fallen for i, fallen in record["falls_if_removed"].items() if fallen} == {"2": [3]}


def test_new_segments_are_numbered_after_the_proposals_largest_id(frame):
    one_region = torch.where(frame.label > 1, 70, frame.label)
    parser = replace(AS_IT_IS, search=RSamp(rounds=3, first=(NoSearch(),)))
    parsed = parser(replace(frame, label=one_region))
    assert len(parsed.ids) > 2
    assert sorted(parsed.ids) == [1, *range(71, 71 + len(parsed.ids) - 1)]


@pytest.mark.parametrize("fixture", ["given", "sampled"])
def test_a_record_follows_the_schema(fixture, request):
    jsonschema.validate(scene_record(request.getfixturevalue(fixture)), scene_schema())


def test_the_label_image_holds_the_ids_of_the_record(sampled, tmp_path):
    write_parsed(sampled, tmp_path)
    label = np.asarray(Image.open(tmp_path / "labels.png"))
    pixels = {i: int((label == i).sum()) for i in np.unique(label).tolist() if i > 0}
    assert pixels == {i: s["pixels"] for i, s in by_id(sampled).items()}
    assert label.dtype == np.uint16


def test_the_blocks_are_found_without_labels(frame, sampled):
    for truth in (2, 3, 4, 5):
        inside = frame.label == truth
        found = sampled.label == sampled.label[inside].mode().values
        assert float((inside & found).sum() / (inside | found).sum()) > 0.7


@pytest.mark.parametrize("proposal", [Watershed(), Felzenszwalb(least_px=300)])
@pytest.mark.parametrize("search", [NoSearch(), Greedy(), RSamp(rounds=2)])
def test_the_same_seed_parses_the_same_twice(frame, proposal, search):
    parser = Parser(proposal, search, toy_potentials(), seed=3)
    one, two = scene_record(parser(frame)), scene_record(parser(frame))
    assert one.pop("seconds").keys() == two.pop("seconds").keys()
    assert one == two


def test_what_is_said_of_segments_and_pairs_agrees_with_the_potentials(frame, sampled):
    potentials, scene = toy_potentials(), sampled.scene
    search_input = make_search_input(observe(frame, estimated_ground), SAMPLED.proposal)
    (one,) = SAMPLED.problem(search_input).describe([scene])
    rows = one.unary
    torch.testing.assert_close(sampled.unary, TwoJudges(potentials)(rows), rtol=0.0, atol=EXACT)
    torch.testing.assert_close(sampled.badness, potentials.unary.badness(rows), rtol=0.0, atol=EXACT)
    pairs, background = scene.pairs, scene.background
    bordering = pairs.neighbours
    judged = ~background[pairs.first[bordering]] & ~background[pairs.second[bordering]]
    assert torch.equal(sampled.pairwise.isfinite(), judged)
    area, smaller = (
        scene.pixel_count.double(),
        scene.pixel_count[torch.stack([pairs.first, pairs.second])].amin(dim=0),
    )
    lost = torch.where(background, one.lost, sampled.unary.clamp(0, 1))
    between = (smaller[bordering] * sampled.pairwise.clamp(0, 1))[judged]
    expected = (area @ lost + potentials.weight * between.sum()) / area.sum()
    assert sampled.energy == pytest.approx(float(expected), abs=EXACT)


def test_a_parse_says_where_it_came_from(frame, sampled):
    assert sampled.name == frame.name
    assert sampled.potentials_name == "toy"
    assert sampled.potentials_sha256 == toy_potentials().sha256
    assert sampled.trace[-1] == sampled.energy
    assert sampled.seconds.keys() == {"observation", "proposal", "pool", "search", "conclusion", "removal"}
    assert replace(AS_IT_IS, seed=9)(frame).seed == 9


def test_up_may_come_from_the_scene(frame):
    up = torch.tensor([0.1, -1.0, -0.6], dtype=torch.float64)
    up = up / up.norm()
    parser = replace(AS_IT_IS, ground_of=given_ground)
    parsed = parser(replace(frame, up_camera=up))
    assert scene_record(parsed)["up_camera"] == pytest.approx(up.tolist(), abs=EXACT)
    assert parsed.scene.ground.confidence == 1.0


def test_up_that_the_scene_does_not_give_is_asked_for(frame):
    with pytest.raises(ValueError, match="blocks has no `up_camera`"):
        replace(AS_IT_IS, ground_of=given_ground)(replace(frame, up_camera=None))


def test_estimated_up_is_that_of_the_table(frame, given):
    assert float(given.scene.ground.up_camera @ frame.up_camera) > 0.9999
    assert given.scene.ground.height == pytest.approx(-0.55, abs=0.002)


def test_regions_without_depth_are_named(frame):
    nowhere = replace(frame, label=torch.where(frame.label == 2, 2, 0))
    blind = replace(nowhere, depth=torch.where(frame.label == 2, 0.0, frame.depth))
    with pytest.raises(ValueError, match="blocks: the proposal leaves no region with depth"):
        AS_IT_IS(blind)


def test_an_image_without_regions_is_named(frame):
    with pytest.raises(ValueError, match="blocks: the proposal leaves no region with depth"):
        AS_IT_IS(replace(frame, label=torch.zeros_like(frame.label)))


def test_a_region_that_is_seen_without_depth_gets_no_segment(frame):
    blind = replace(frame, depth=torch.where(frame.label == 5, 0.0, frame.depth))
    assert sorted(AS_IT_IS(blind).ids) == [1, 2, 3, 4]


def test_one_segment_alone_is_understood(frame):
    one = AS_IT_IS(replace(frame, label=torch.where(frame.label == 2, 2, 0)))
    assert one.ids == (2,)
    assert scene_record(one)["pairs"] == []


def test_a_proposal_of_the_users_own_needs_no_more_than_to_be_called(frame):
    class Halves:
        def __call__(self, observation):
            columns = torch.arange(frame.depth.shape[1]).expand_as(frame.depth)
            return Proposed(1 + (columns >= frame.depth.shape[1] // 2).long())

    parsed = Parser(Halves(), NoSearch(), toy_potentials())(frame)
    assert sorted(parsed.ids) == [1, 2]


def test_every_proposed_region_is_a_set_of_atoms(frame):
    observation = observe(frame, estimated_ground)
    for proposal in (LabelFile(), Watershed(), Felzenszwalb()):
        search_input = make_search_input(observation, proposal)
        painted = search_input.start.labels(search_input.atoms)
        inside = painted > 0
        assert torch.equal(inside, search_input.label > 0)
        pairs = torch.stack([painted[inside], search_input.label[inside]], dim=1).unique(dim=0)
        assert len(pairs) == len(search_input.start) == len(search_input.label[inside].unique())
