"""Training rows from a photograph whose truth is known."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import pytest
import torch

from blockstab.features.columns import COLUMNS
from blockstab.features.unary import unary_features
from blockstab.proposals.files import LabelFile
from blockstab.proposals.watershed import Watershed
from blockstab.rgbd.frame import Frame
from blockstab.search.moves.every import EVERY
from blockstab.search.moves.merge import Merge
from blockstab.search.moves.split import Split
from blockstab.search.none import NoSearch
from blockstab.testing.photographs import BLOCKS, photograph
from models.potentials.examples import ExampleMaker, Neutral
from models.potentials.heads import CLIP, LinearHead
from models.potentials.rows import KINDS, Examples
from models.potentials.training import train_potential
from tests.synthetic import builder, view_of
from tests.toy_potentials import toy_potentials

FRAME = photograph(*BLOCKS).frame
MAKER = ExampleMaker((Watershed(),), EVERY, walks=1, steps=3, most_states=8, most_masks=20)
CLEAN = replace(MAKER, proposals=(LabelFile(),), walks=0)


def made(maker: ExampleMaker = MAKER, seed: int = 0, frame: Frame = FRAME) -> Examples:
    return maker(frame, torch.Generator().manual_seed(seed))


examples = cache(made)
every_kind = pytest.mark.parametrize("kind", KINDS)


class Visit:
    """A search that looks at two blocks as one, and stays."""

    def __call__(self, start, problem, generator):
        problem.rate([start.merge(1, 2)])
        return NoSearch()(start, problem, generator)


class Halve:
    """A search that looks at one block as two, and stays."""

    def __call__(self, start, problem, generator):
        whole = start.segments[1]
        problem.rate([start.replace(1, problem.split(whole))])
        return NoSearch()(start, problem, generator)


VISITING = replace(CLEAN, search=Visit(), potentials=toy_potentials())


@every_kind
def test_rows_are_finite_and_lose_something_between_nothing_and_all(kind):
    rows = getattr(examples(), kind)
    assert rows.features.shape == (len(rows.target), len(COLUMNS[kind]))
    assert rows.features.dtype == torch.float32
    assert bool(rows.features.isfinite().all())
    assert rows.target.dtype == rows.pixel_count.dtype == torch.float64
    assert bool(((rows.target >= 0) & (rows.target <= 1)).all())
    assert float(rows.target.amin()) < 0.1 < 0.9 < float(rows.target.amax())
    assert bool((rows.pixel_count > 0).all())


def test_true_segments_are_good_examples():
    search_input = view_of(photograph(*BLOCKS))
    (scene,) = builder(search_input)([search_input.start])
    found = made(replace(MAKER, proposals=(LabelFile(),))).unary
    for row in unary_features(scene)[~scene.background]:
        distance = (found.features[:, :30] - row).abs() / row.abs().clamp(min=1.0)
        same = distance.amax(dim=1) < 0.02  # the ground is estimated, not given
        assert bool(same.any())
        assert not bool(found.target[same].any())


def test_background_is_no_example_of_a_segment():
    table = float((FRAME.label == 1).sum())
    found = made(replace(MAKER, moves=(Split(), Merge())))  # none that turns it into an object
    assert float(found.unary.pixel_count.amax()) < 0.5 * table
    assert float(found.alone.pixel_count.amax()) > 0.9 * table  # but by itself it is judged


def test_the_truth_and_a_start_that_is_true_lose_nothing():
    clean = made(CLEAN)
    assert not bool(clean.unary.target.any())
    assert not bool(clean.pairwise.target.any())
    assert len(clean.pairwise.target) > 0
    assert clean.states.error.tolist() == [0.0, 0.0]


def test_a_boundary_loses_what_its_two_segments_would_gain_as_one():
    true, halved = made(CLEAN), made(replace(VISITING, search=Halve()))
    assert not bool(true.pairwise.target.any())
    assert not bool(true.pairwise.bad.any())
    seam = halved.pairwise.target == halved.pairwise.target.amax()
    assert int(seam.sum()) == 1
    assert float(halved.pairwise.target[seam]) > 0.9  # as one they are a block
    assert float(halved.pairwise.target[~seam].amax()) < 0.02
    assert halved.pairwise.bad[seam].all()


def test_to_the_paper_a_boundary_is_bad_if_either_side_is():
    found = made(VISITING)
    assert int(found.unary.bad.sum()) == 1
    assert len(found.unary.target) == 4 + 1  # each segment once, however many segmentations have it
    assert 0 < int(found.pairwise.bad.sum()) < len(found.pairwise.bad)
    assert not bool(found.pairwise.target.any())  # two blocks taken for one gain nothing with a third


def test_every_atom_and_every_lone_segment_tells_of_background_by_the_things_in_it():
    found = made(CLEAN)
    atoms = len(view_of(photograph(*BLOCKS)).atoms)
    share, pixels = found.background.target, found.background.pixel_count
    assert set(share[:atoms].tolist()) == {0.0, 1.0}
    assert float((share * pixels)[:atoms].sum()) == float((FRAME.label > 1).sum())
    assert atoms < len(share) <= atoms + len(found.alone.target)
    assert bool(((share >= 0) & (share <= 1)).all())
    # Masks of the pool may be things in part.
    assert bool(((share[atoms:] > 0) & (share[atoms:] < 1)).any())


def test_masks_of_the_pool_are_looked_at_by_themselves():
    few, many = (made(replace(CLEAN, most_masks=n)).alone for n in (0, 20))
    assert len(few.target) == 5  # the truth
    assert len(few.target) < len(many.target) <= len(few.target) + 20


def test_the_truth_comes_first_among_whole_segmentations_and_has_the_least_error():
    states = examples().states
    assert 2 < len(states.error) == states.parts.count <= MAKER.most_states
    assert float(states.error[0]) == float(states.error.amin())
    assert float(states.error[0]) < 0.02 < float(states.error.amax())
    assert states.unary.shape == (len(states.loss), len(COLUMNS["unary"]))
    assert states.pairwise.shape == (len(states.parts.smaller), len(COLUMNS["pairwise"]))
    assert states.parts.segment_of.unique().tolist() == list(range(states.parts.count))
    pixels = torch.zeros(states.parts.count).double().index_add(0, states.parts.segment_of, states.parts.area)
    assert len(set(pixels.tolist())) == 1  # all divide the same


def test_more_and_longer_walks_give_more_rows():
    longer = made(replace(MAKER, walks=2, steps=6, most_states=30))
    assert len(longer.unary.target) > len(examples().unary.target)
    assert len(longer.states.error) > len(examples().states.error)


def test_with_potentials_a_search_decides_what_is_visited():
    found = made(replace(VISITING, walks=9))
    assert len(found.states.error) == 4  # the truth, the start, its visit, and the start again
    without = made(replace(VISITING, potentials=None))
    assert len(without.states.error) == 2


@every_kind
def test_the_same_seed_makes_the_same_rows_and_another_one_others(kind):
    again, other = made(), made(seed=1)
    for one, two in zip(getattr(again, kind), getattr(examples(), kind), strict=True):
        assert torch.equal(one, two)
    assert not torch.equal(other.states.error, examples().states.error)


def test_examples_are_made_from_the_generator_alone():
    before = torch.get_rng_state()
    made()
    assert torch.equal(torch.get_rng_state(), before)


def test_an_image_without_labels_is_refused():
    with pytest.raises(ValueError, match=r"blocks has no label\.png"):
        made(frame=replace(FRAME, label=None))


def test_of_two_proposals_the_rows_of_the_first_come_first():
    maker = replace(CLEAN, proposals=(Watershed(), LabelFile()))
    both, first = made(maker), made(replace(maker, proposals=(Watershed(),)))
    for kind in KINDS:
        rows, start = getattr(both, kind), getattr(first, kind)
        assert torch.equal(rows.target[: len(start.target)], start.target)
        assert len(rows.target) > len(start.target)
    one, two = first.states, both.states
    assert two.error.tolist() == [*one.error.tolist(), 0.0, 0.0]
    assert two.parts.segment_of[: len(one.loss)].tolist() == one.parts.segment_of.tolist()
    assert two.parts.segment_of[len(one.loss) :].unique().tolist() == [2, 3]
    assert int(two.parts.boundary_of.max()) == 3


def test_features_with_long_tails_are_not_clipped_once_they_are_compressed():
    rows, columns = made(replace(MAKER, walks=4)).pairwise, COLUMNS["pairwise"]
    weight = torch.ones(len(rows.target)).double()
    potential = train_potential(
        rows.features, rows.target, weight, columns, LinearHead, c=1.0, epochs=1, seed=0
    )
    standard = potential.standardised(rows.features)
    for name in ("density", "volume_ratio"):
        column = columns.index(name)
        assert float(rows.features[:, column].amax() / rows.features[:, column].median()) > CLIP, name
        assert float(standard[:, column].abs().amax()) < CLIP, name
        assert float(standard[:, column].std()) > 0.9, name


def test_neutral_potentials_find_everything_alike():
    for kind in KINDS:
        assert getattr(Neutral(), kind)(torch.rand(3, 5)).tolist() == [0.5] * 3
    assert Neutral().weight == 0.0
