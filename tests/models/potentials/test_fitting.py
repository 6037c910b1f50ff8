"""From examples to potentials of every kind, on tiny random examples."""

from __future__ import annotations

from collections.abc import Iterator
from functools import cache, partial

import pytest
import torch

from blockstab.energy.overlap import Parts, expected_loss
from blockstab.features.columns import COLUMNS, FEATURE_SETS, feature_set
from models.potentials import fitting
from models.potentials.checkpoint import load_potentials, save_potentials
from models.potentials.fitting import Fitted, fit_all
from models.potentials.heads import LinearHead, MLPHead, TreesHead
from models.potentials.potential import fold_of
from models.potentials.rows import GOOD, KINDS, Examples, Rows, States, joined_parts
from models.potentials.structured import held_out_weight

IMAGES, ROWS, FOLDS = 3, 80, 2
HEADS = {
    "linear": LinearHead,
    "mlp": partial(MLPHead, hidden=4),
    "trees": partial(TreesHead, trees=30, leaves=4),
}
# The one column that tells the loss, of each kind.
TELLING = {
    "unary": "pixels_log",
    "pairwise": "center_distance",
    "alone": "saddle",
    "background": "ground_share",
}
every_head = pytest.mark.parametrize("head", HEADS)


def rows(kind: str, generator: torch.Generator) -> Rows:
    """Random features, one of which is twice the loss."""
    features = torch.rand(ROWS, len(COLUMNS[kind]), generator=generator)
    column = COLUMNS[kind].index(TELLING[kind])
    target = (torch.rand(ROWS, generator=generator).double() - 0.2).clamp(min=0.0)
    features[:, column] = 2 * target.float()
    return Rows(features, target, target > GOOD, (1 + 500 * torch.rand(ROWS, generator=generator)).double())


def states(generator: torch.Generator) -> States:
    """The truth and two other segmentations, of three objects and background each."""
    area = torch.tensor([500.0, 100.0, 60.0, 40.0]).double()
    background = torch.tensor([True, False, False, False])
    zeros = torch.zeros(4, dtype=torch.int64)
    losses = [torch.zeros(4).double(), *(torch.rand(4, generator=generator).double() for _ in range(2))]
    parts = [Parts(area, background, 0.0 * area, area[2:], zeros, zeros[:2]) for _ in losses]
    none = torch.zeros(2).double()
    unary = torch.rand(12, len(COLUMNS["unary"]), generator=generator)
    unary[:, COLUMNS["unary"].index(TELLING["unary"])] = 2 * torch.cat(losses).float()
    return States(
        unary,
        torch.rand(6, len(COLUMNS["pairwise"]), generator=generator),
        torch.cat(losses),
        torch.stack([expected_loss(p, loss, none, 0.0) for p, loss in zip(parts, losses, strict=True)]),
        joined_parts(parts),
    )


@cache
def examples() -> list[Examples]:
    generator = torch.Generator().manual_seed(5)
    return [Examples(*(rows(kind, generator) for kind in KINDS), states(generator)) for _ in range(IMAGES)]


def fitted(head: str = "linear", features: str = "all", most_rows: int = 10**6, **changes: object) -> Fitted:
    settings = {
        "target": "overlap",
        "structured": False,
        "weight": None,
        "folds": FOLDS,
        "seed": 0,
        "jobs": 1,
        **changes,
    }
    return fit_all(
        examples(), HEADS[head], feature_set(features), most_rows=most_rows, **{**settings, **changes}
    )


@pytest.fixture(autouse=True, scope="module")
def quick() -> Iterator[None]:
    """Few epochs, and one C to choose from."""
    with pytest.MonkeyPatch.context() as patch:
        for head in (LinearHead, MLPHead):
            patch.setattr(head, "grid", (1.0,))
        for name in ("choose_c", "cross_fit"):
            patch.setattr(fitting, name, partial(getattr(fitting, name), epochs=3))
        yield


known = cache(fitted)  # for the tests that only look at it


@every_head
@pytest.mark.parametrize("target", ["overlap", "bit"])
def test_potentials_of_every_kind_tell_good_from_bad(head, target):
    found = known(head, target=target)
    assert tuple(found.potentials) == KINDS
    for kind, potential in found.potentials.items():
        assert potential.columns == COLUMNS[kind]
        all_rows = [getattr(one, kind) for one in examples()]
        values = torch.cat([potential(part.features) for part in all_rows])
        loss = torch.cat([part.target for part in all_rows])
        assert float(values[loss > 0.5].mean()) > float(values[loss < 0.1].mean()) + 0.15, kind
        badness = torch.cat([potential.badness(part.features) for part in all_rows])
        assert float(badness[loss > 0.5].mean()) > float(badness[loss == 0].mean()) + 0.15, kind


def test_the_overlap_is_a_target_of_degrees_and_the_bit_is_none():
    overlap, bit = (known("trees", target=target).potentials["unary"] for target in ("overlap", "bit"))
    column = COLUMNS["unary"].index(TELLING["unary"])
    row = torch.full((3, len(COLUMNS["unary"])), 0.5)
    row[:, column] = 2 * torch.tensor([0.0, 0.4, 0.75])
    good, half, bad = overlap(row).tolist()
    assert good < half < bad
    good, half, bad = bit(row).tolist()
    assert bad - half < 0.2 * (half - good)


def test_lone_segments_and_background_learn_degrees_whatever_the_target():
    for kind in ("alone", "background"):
        one, other = (known("linear", target=target).potentials[kind] for target in ("overlap", "bit"))
        state, expected = one.state_dict(), other.state_dict()
        assert all(torch.equal(state[name], expected[name]) for name in state)


@pytest.mark.parametrize("features", FEATURE_SETS)
def test_potentials_see_the_columns_of_their_set(features):
    found = known("linear", features)
    for kind, potential in found.potentials.items():
        assert potential.columns == feature_set(features).of(kind)


@every_head
def test_boundaries_weigh_what_potentials_find_that_had_not_seen_the_image(head):
    found = known(head)
    judges = [found.ready(k) for k in fold_of(torch.arange(IMAGES), FOLDS).tolist()]
    assert found.weight == held_out_weight(judges, [one.states for one in examples()])
    assert found.facts["weight"] == round(found.weight, 5)


def test_a_weight_of_boundaries_may_be_given():
    assert fitted("linear", "paper", weight=0.25).weight == 0.25


@every_head
def test_from_whole_segmentations_heads_with_a_gradient_learn_on(head):
    found, before = known(head, structured=True), known(head)
    unary, plain = found.potentials["unary"], before.potentials["unary"]
    same = all(
        torch.equal(one, other)
        for one, other in zip(unary.head.parameters(), plain.head.parameters(), strict=True)
    )
    assert same == (found.weight == before.weight) == (head == "trees")
    assert not any(p.requires_grad for p in unary.parameters())


def test_a_fold_is_judged_by_what_has_learned_from_the_others():
    found = known("trees")
    for kind in KINDS:
        values = [getattr(found.ready(k), kind)(getattr(examples()[0], kind).features) for k in range(FOLDS)]
        assert not torch.equal(*values)
        assert torch.equal(values[1], found.unseen[1][kind](getattr(examples()[0], kind).features))


def test_the_set_of_columns_may_be_a_part_when_whole_segmentations_are_learned_from():
    found = known("linear", "paper_without_stability", structured=True)
    assert found.potentials["unary"].columns == feature_set("paper_without_stability").unary


def test_facts_tell_rows_shares_and_the_chosen_c():
    facts = known().facts
    for kind in KINDS:
        target = torch.cat([getattr(one, kind).target for one in examples()])
        assert facts[kind]["rows"] == IMAGES * ROWS
        assert facts[kind]["bad_share"] == pytest.approx(float((target > 0.1).double().mean()), abs=1e-4)
        assert facts[kind]["c"] == 1.0
        assert facts[kind]["held_out_loss"] is None  # there is one C to choose from


def test_of_several_c_the_one_that_was_chosen_is_told_with_its_loss(monkeypatch):
    monkeypatch.setattr(LinearHead, "grid", (1e-6, 1.0))
    facts = fitted("linear", "paper").facts
    for kind in KINDS:
        assert facts[kind]["c"] == 1.0
        assert 0 <= facts[kind]["held_out_loss"] < 0.2


def test_of_many_rows_so_many_are_drawn_and_the_same_ones_again():
    one, again, other = (fitted("trees", most_rows=150, seed=seed) for seed in (0, 0, 1))
    assert one.facts["unary"]["rows"] == 150
    assert one.facts == again.facts
    assert other.facts != one.facts


def test_larger_segments_pull_the_potential_more_where_degrees_are_learned():
    generator = torch.Generator().manual_seed(1)
    half = torch.arange(ROWS) % 2
    flat = Rows(torch.zeros(ROWS, len(COLUMNS["unary"])), half.double(), half > 0, torch.ones(ROWS).double())
    heavy = flat._replace(pixel_count=torch.where(flat.target > 0, 900.0, 1.0).double())
    means = {}
    for name, unary in (("even", flat), ("heavy", heavy)):
        some = [
            Examples(unary, *(rows(kind, generator) for kind in KINDS[1:]), states(generator))
            for _ in range(IMAGES)
        ]
        found = fit_all(some, HEADS["trees"], feature_set("all"), "overlap", False, None, 10**6, FOLDS, 0, 1)
        means[name] = float(found.potentials["unary"](flat.features).mean())
    assert means["even"] == pytest.approx(0.5, abs=0.05)
    assert means["heavy"] > 0.85  # the root of 900 counts thirty times


@every_head
def test_what_was_fitted_is_ready_for_a_search_and_for_the_disk(head, tmp_path):
    found = known(head, structured=True)
    save_potentials(tmp_path / "mine", found.potentials, found.weight, {"facts": found.facts})
    loaded, ready = load_potentials(tmp_path / "mine"), found.ready(1)
    assert (ready.name, ready.weight) == ("fold 1", loaded.weight)
    for kind in KINDS:
        potential = found.potentials[kind]
        some = getattr(examples()[0], kind).features[:, [COLUMNS[kind].index(c) for c in potential.columns]]
        assert torch.equal(potential(some), getattr(loaded, kind)(some))


def test_a_target_of_another_name_is_refused():
    with pytest.raises(ValueError, match="overlap or bit, but it is 'iou'"):
        fitted(target="iou")
