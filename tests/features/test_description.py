"""Scenes described: each segment looked at once, and the same in any company."""

from __future__ import annotations

from dataclasses import replace

import pytest
import torch
from torch import Tensor

from blockstab.features.appearance.pair_cache import Appearances
from blockstab.features.box_shape import BOX_SHAPE_COLUMNS, box_shape
from blockstab.features.columns import LONE_COLUMNS, SEGMENT_COLUMNS
from blockstab.features.description import Describer
from blockstab.features.pairwise import PAIRWISE_COLUMNS, pairs_of, pairwise_features
from blockstab.features.unary import UNARY_COLUMNS, unary_features
from blockstab.segments.hierarchy import build_hierarchy
from tests.own_columns import Height
from tests.search.watched import blocks_view
from tests.synthetic import builder, over_split, variants
from tests.tolerance import COMPANY

SEARCH_INPUT = blocks_view()


def things(rows: Tensor) -> Tensor:
    """The share of things, from the ground that the image shows."""
    return 1.0 - rows[:, LONE_COLUMNS.index("ground_share")]


def describer(background=things, own=()) -> Describer:
    hierarchy = build_hierarchy(SEARCH_INPUT.atoms)
    return Describer(SEARCH_INPUT.observation, SEARCH_INPUT.atoms, hierarchy, background, own)


SCENES = builder(SEARCH_INPUT)(variants(SEARCH_INPUT, 8))


def test_a_row_is_table_1_then_the_box_then_the_segment_by_itself():
    describe = describer()
    for scene, one in zip(SCENES, describe(SCENES), strict=True):
        table, box = len(UNARY_COLUMNS), len(UNARY_COLUMNS) + len(BOX_SHAPE_COLUMNS)
        assert one.scene is scene
        assert one.unary.shape == (len(scene), len(SEGMENT_COLUMNS))
        assert torch.equal(one.unary[:, :table], unary_features(scene))
        shape = box_shape(
            scene.boxes,
            scene.pixel_count,
            SEARCH_INPUT.observation.frame.camera,
            SEARCH_INPUT.observation.ground,
        )
        assert torch.equal(one.unary[:, table:box], shape)
        assert torch.equal(one.unary[:, box:], describe.lone(scene.segmentation.segments))
        assert bool(one.unary.isfinite().all())


def test_columns_of_ones_own_stand_last():
    mine = describer(own=[Height(0.1)])(SCENES)
    for scene, one, plain in zip(SCENES, mine, describer()(SCENES), strict=True):
        assert torch.equal(one.unary[:, :-1], plain.unary)
        assert torch.equal(one.unary[:, -1], scene.boxes.center[:, 1] - 0.1)


def test_pairs_are_described_by_their_boxes_and_their_looks():
    look = Appearances(SEARCH_INPUT.observation, SEARCH_INPUT.atoms)
    for one in describer()(SCENES):
        assert one.pairwise.shape == (len(pairs_of(one.scene)), len(PAIRWISE_COLUMNS))
        expected = pairwise_features(one.scene, look(pairs_of(one.scene)))
        torch.testing.assert_close(one.pairwise, expected, rtol=0.0, atol=COMPANY)


def test_what_is_lost_in_background_is_the_things_in_its_atoms():
    label = SEARCH_INPUT.observation.frame.label
    for scene, one in zip(SCENES, describer()(SCENES), strict=True):
        for segment, share in zip(scene.segmentation.segments, one.lost.tolist(), strict=True):
            inside = torch.isin(SEARCH_INPUT.atoms.label - 1, torch.tensor(sorted(segment)))
            ground = (SEARCH_INPUT.observation.on_ground & inside).double().sum() / inside.sum()
            assert share == pytest.approx(1.0 - float(ground))
    truth = describer()([SCENES[0]])[0]
    assert label is not None
    assert float(truth.lost[0]) < 0.02
    assert float(truth.lost[1:].amin()) > 0.9


@pytest.mark.parametrize(("says", "share"), [(-3.0, 0.0), (0.25, 0.25), (7.0, 1.0)])
def test_shares_of_things_are_kept_between_nothing_and_all(says, share):
    (one,) = describer(lambda rows: torch.full((len(rows),), says).double())([SCENES[0]])
    assert one.lost.tolist() == pytest.approx([share] * len(one.lost))


def test_scenes_are_the_same_within_1e_9_in_whatever_company_they_are_described():
    together, grown = describer()(SCENES), describer()
    for order in (range(len(SCENES)), reversed(range(len(SCENES)))):
        for k in order:
            (one,) = grown([SCENES[k]])
            for name in ("unary", "pairwise", "lost"):
                expected = getattr(together[k], name)
                torch.testing.assert_close(getattr(one, name), expected, rtol=0.0, atol=COMPANY)


def test_lone_rows_come_in_the_order_they_are_asked_for():
    describe, segments = describer(), over_split(SEARCH_INPUT).segments
    rows = describe.lone(segments)
    assert torch.equal(describe.lone(segments[::-1]), rows.flip(0))
    assert torch.equal(describe.lone([segments[2], segments[2]]), rows[[2, 2]])
    assert describe.lone([]).shape == (0, len(LONE_COLUMNS))


def test_what_surrounds_a_segment_is_not_in_its_lone_row_but_its_stability_is_in_its_unary_row():
    describe = describer()
    lower = SEARCH_INPUT.start.segments.index(min(SEARCH_INPUT.start.segments[1:], key=lambda s: -len(s)))
    scene = SCENES[0]
    fallen = replace(scene, balance=replace(scene.balance, stable=torch.zeros_like(scene.balance.stable)))
    one, other = describe([scene, fallen])
    column = SEGMENT_COLUMNS.index("stable")
    assert bool((one.unary[:, column] != other.unary[:, column]).all())
    assert torch.equal(one.unary[lower, -len(LONE_COLUMNS) :], other.unary[lower, -len(LONE_COLUMNS) :])
