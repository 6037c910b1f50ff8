"""Training rows from a photograph whose truth is known."""

from __future__ import annotations

from dataclasses import replace

import pytest
import torch

from blockstab.features.unary import UNARY_COLUMNS, unary_features
from blockstab.proposals.files import LabelFile
from blockstab.proposals.watershed import Watershed
from models.examples import COLUMNS, MERGES_JUDGED, ExampleMaker, Examples, Rows, joined
from models.heads import CLIP, LinearHead
from models.training import train_potential
from tests.synthetic import BLOCKS, interpreter, photograph, view_of

FRAME = photograph(*BLOCKS).frame


def made(maker: ExampleMaker | None = None, seed: int = 0) -> Examples:
    return (maker or ExampleMaker(Watershed(), variants=2))(FRAME, torch.Generator().manual_seed(seed))


@pytest.fixture(scope="module")
def examples() -> Examples:
    return made()


@pytest.mark.parametrize("kind", Examples._fields)
def test_rows_are_finite_and_labelled_good_or_bad(examples, kind):
    rows = getattr(examples, kind)
    assert rows.features.shape == (len(rows.target), len(COLUMNS[kind]))
    assert bool(rows.features.isfinite().all())
    assert rows.features.dtype == rows.target.dtype == torch.float64
    assert set(rows.target.tolist()) == {0.0, 1.0}


def test_true_segments_are_good_examples(examples):
    view = view_of(photograph(*BLOCKS))
    (scene,) = interpreter(view)([view.start])
    for row in unary_features(scene)[~scene.background]:
        distance = (examples.unary.features - row).abs() / row.abs().clamp(min=1.0)
        same = distance.amax(dim=1) < 0.02  # the ground is estimated, not given
        assert bool(same.any())
        assert not bool(examples.unary.target[same].any())


def test_background_is_no_example(examples):
    # Nothing else has as few points for the volume of its box as the table.
    column = examples.unary.features[:, UNARY_COLUMNS.index("density")]
    view = view_of(photograph(*BLOCKS))
    (scene,) = interpreter(view)([view.start])
    table = unary_features(scene)[0, UNARY_COLUMNS.index("density")]
    assert bool(((column - table).abs() > 0.02 * table).all())


def test_a_boundary_is_bad_where_one_of_its_segments_is():
    # Without spoiling, and from the true labels alone, every segment and so every boundary is good.
    truth = ExampleMaker(LabelFile(), variants=0)
    clean = made(truth)
    assert not bool(clean.unary.target.any())
    assert not bool(clean.pairwise.target.any())
    assert len(clean.pairwise.target) > 0


def test_two_objects_should_not_merge_and_two_parts_of_one_should():
    clean = made(ExampleMaker(LabelFile(), variants=0))
    assert bool(clean.merge.target.all())  # all pairs are of different objects
    assert not bool(made().merge.target.all())


def test_more_variants_give_more_rows(examples):
    assert len(made(ExampleMaker(Watershed(), variants=8)).unary.target) > len(examples.unary.target)


def test_few_merges_of_one_segmentation_are_judged(examples):
    segmentations = 2 * (1 + 2 // 2)
    assert 0 < len(examples.merge.target) <= segmentations * MERGES_JUDGED


def test_the_same_seed_makes_the_same_rows(examples):
    again, other = made(), made(seed=1)
    for kind in Examples._fields:
        assert torch.equal(getattr(again, kind).features, getattr(examples, kind).features)
        assert torch.equal(getattr(again, kind).target, getattr(examples, kind).target)
    assert not torch.equal(other.unary.features, examples.unary.features)


def test_an_image_without_labels_is_refused():
    with pytest.raises(ValueError, match=r"blocks has no label\.png"):
        ExampleMaker(Watershed())(replace(FRAME, label=None), torch.Generator())


def test_joined_rows_keep_their_order():
    def one(value: float, n: int) -> Examples:
        return Examples(
            *(Rows(torch.full((n, len(COLUMNS[k])), value), torch.full((n,), value)) for k in COLUMNS)
        )

    both = joined([one(0.0, 2), one(1.0, 3)])
    assert both.pairwise.target.tolist() == [0.0, 0.0, 1.0, 1.0, 1.0]
    assert both.merge.features.shape == (5, 121)


def test_features_with_long_tails_are_not_clipped_once_they_are_compressed(examples):
    rows = examples.pairwise
    potential = train_potential(
        *rows, torch.ones(len(rows.target)).double(), COLUMNS["pairwise"], LinearHead, c=1.0, epochs=1, seed=0
    )
    standard = potential.standardised(rows.features)
    for name in ("density", "volume_ratio", "slenderness_greatest"):
        column = COLUMNS["pairwise"].index(name)
        assert float(rows.features[:, column].amax() / rows.features[:, column].median()) > CLIP, name
        assert float(standard[:, column].abs().amax()) < CLIP, name
        assert float(standard[:, column].std()) > 0.9, name


def test_columns_are_those_of_the_features():
    assert [len(COLUMNS[kind]) for kind in Examples._fields] == [30, 63, 121]
