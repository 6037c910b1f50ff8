"""Every option of every group of configurations makes a part that works."""

from __future__ import annotations

from functools import partial

import pytest
import torch
from hydra.utils import instantiate

from blockstab.energy.overlap import CAUTION, TURNING, expected_overlap
from blockstab.energy.paper import paper_energy
from blockstab.energy.truth import true_overlap
from blockstab.features.columns import FeatureSet
from models.potentials.heads import HEADS
from tests.docs.pages import ROOT, composed
from tests.search.watched import blocks_view, seeded, watched
from tests.synthetic import over_split


def options(group: str) -> pytest.MarkDecorator:
    return pytest.mark.parametrize("name", sorted(f.stem for f in (ROOT / "configs" / group).glob("*.yaml")))


def made(program: str, group: str, name: str) -> object:
    return instantiate(composed(program, [f"{group}={name}"])[group])


@options("search")
def test_every_search_finds_something(name):
    search = made("evaluate", "search", name)
    found = search(over_split(blocks_view()), watched(blocks_view()).problem, seeded(0))
    assert len(found.trace) == len(found.bests) > 0


@options("pool")
def test_every_pool_offers_sets_of_atoms(name):
    masks = made("train", "pool", name)(blocks_view())
    assert bool(masks) == (name != "none")
    assert all(type(mask) is frozenset for mask in masks)


@options("energy")
def test_every_energy_is_made_for_an_image(name):
    energy = instantiate(composed("evaluate", [f"energy={name}"]).energy)
    made_of = energy.func if isinstance(energy, partial) else energy
    assert not isinstance(energy, partial) or energy.keywords == {"caution": CAUTION, "turning": TURNING}
    assert made_of is {"overlap": expected_overlap, "paper": paper_energy, "truth": true_overlap}[name]
    (rating,) = watched(blocks_view(), energy).problem.rate([blocks_view().start])
    assert rating.energy.shape == ()


@options("features")
def test_every_set_of_features_is_one(name):
    assert type(made("train", "features", name)) is FeatureSet


@options("potential")
def test_every_potential_is_a_head_over_any_number_of_features(name):
    head = made("train", "potential", name)(5)
    assert type(head) in HEADS.values()
    assert head(torch.zeros(3, 5)).shape == (3,)
