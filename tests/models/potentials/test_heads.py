"""The contract that every head keeps, and the potential around it."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest
import torch

from models.potentials.checkpoint import load_potentials, save_potentials
from models.potentials.heads import CLIP, HEADS, Potential, TreesHead, initialised
from models.potentials.rows import KINDS

COLUMNS = ("volume", "tilt", "density")


def potential(name: str, seed: int = 0) -> Potential:
    head = initialised(HEADS[name], len(COLUMNS), seed)
    head = head.grown(*rows(), 1.0, seed) or head
    return Potential(
        COLUMNS, head, torch.tensor([1.0, 2.0, 3.0]), torch.tensor([1.0, 0.5, 2.0]), a=4.0, b=-2.0
    )


def rows(count: int = 300) -> tuple[torch.Tensor, torch.Tensor, torch.Tensor]:
    """Standardised features, a target that no linear rule of them gives, and weights."""
    features = torch.randn(count, 3, generator=torch.Generator().manual_seed(3), dtype=torch.float64)
    return features, (features[:, 0] * features[:, 1] > 0).double(), torch.ones(count, dtype=torch.float64)


following_a_gradient = pytest.mark.parametrize("name", sorted(set(HEADS) - {"trees"}))
every_head = pytest.mark.parametrize("name", sorted(HEADS))


@every_head
@pytest.mark.parametrize("rows", [0, 1, 5])
@pytest.mark.parametrize("dtype", [torch.float32, torch.float64])
def test_a_head_gives_one_double_per_row(name, rows, dtype, generator):
    features = torch.randn(rows, 3, generator=generator, dtype=dtype)
    potentials = potential(name)(features)
    assert potentials.shape == (rows,)
    assert potentials.dtype == torch.float64
    assert potential(name).badness(features).shape == (rows,)


@following_a_gradient
def test_gradients_reach_the_features_and_every_parameter(name, generator):
    fitted = potential(name)
    features = torch.randn(50, 3, generator=generator, dtype=torch.float64, requires_grad=True)
    fitted(features).sum().backward()
    assert bool((features.grad.abs().sum(dim=0) > 0).all())
    assert all(p.grad is not None and bool((p.grad != 0).any()) for p in fitted.head.parameters())


@following_a_gradient
def test_the_first_parameters_follow_from_the_seed_alone(name):
    torch.manual_seed(1)
    before = torch.get_rng_state()
    one = initialised(HEADS[name], 3, seed=5).state_dict()
    assert torch.equal(torch.get_rng_state(), before)
    torch.manual_seed(2)
    two, other = (
        initialised(HEADS[name], 3, seed=5).state_dict(),
        initialised(HEADS[name], 3, seed=6).state_dict(),
    )
    assert all(torch.equal(one[key], two[key]) for key in one)
    assert not all(torch.equal(one[key], other[key]) for key in one)


@every_head
def test_saving_and_loading_keeps_every_bit(name, generator, tmp_path):
    kept = {kind: potential(name, seed) for seed, kind in enumerate(KINDS)}
    save_potentials(tmp_path / "mine", kept, 0.25, {})
    loaded = load_potentials(tmp_path / "mine.json")
    features = torch.randn(40, 3, generator=generator, dtype=torch.float64)
    for kind, saved in kept.items():
        read = getattr(loaded, kind)
        assert torch.equal(read(features), saved(features))
        assert torch.equal(read.badness(features), saved.badness(features))
        assert read.columns == COLUMNS
        assert type(read.head) is HEADS[name]
    assert loaded.weight == 0.25


@every_head
def test_potentials_of_a_row_do_not_depend_on_the_rows_beside_it(name, generator):
    features = torch.randn(64, 3, generator=generator, dtype=torch.float64)
    alone = torch.cat([potential(name)(row[None]) for row in features])
    torch.testing.assert_close(potential(name)(features), alone, rtol=0, atol=1e-14)


def test_the_linear_head_is_the_weighted_sum_of_clipped_standard_scores():
    fitted = potential("linear")
    with torch.no_grad():
        fitted.head.linear.weight.copy_(torch.tensor([[1.0, 10.0, 100.0]]))
        fitted.head.linear.bias.fill_(0.25)
    # Two deviations above, one below, and a thousand above, which counts as `CLIP`.
    row = torch.tensor([[3.0, 1.5, 2003.0]])
    assert fitted(row).item() == pytest.approx(2.0 - 10.0 + 100.0 * CLIP + 0.25, abs=1e-12)


def test_trees_learn_what_no_linear_rule_can_and_the_same_trees_from_the_same_seed():
    features, target, weight = rows(1000)
    trees = TreesHead(3, trees=40, leaves=6)
    grown, again, other = (trees.grown(features, target, weight, 1.0, seed) for seed in (0, 0, 1))
    assert float(((grown(features) - target).abs() < 0.5).double().mean()) > 0.95
    assert torch.equal(grown.text, again.text)
    assert not torch.equal(grown.text, other.text)
    assert grown.arguments == {"trees": 40, "leaves": 6, "length": len(grown.text)}


def test_rows_of_greater_weight_pull_the_trees_and_a_smaller_c_holds_them_back():
    features, target, weight = rows()
    trees = TreesHead(3, trees=20, leaves=4)
    bad = trees.grown(features, target, torch.where(target > 0.5, 9.0, 1.0).double(), 1.0, 0)
    even, held = (trees.grown(features, target, weight, c, 0) for c in (1.0, 1e-6))
    assert float(bad(features).mean()) > float(even(features).mean()) + 0.1
    assert float(held(features).std()) < 0.01 * float(even(features).std())


def test_trees_that_have_not_grown_find_everything_good_and_ask_for_no_gradient():
    assert TreesHead(3)(torch.randn(5, 3)).tolist() == [0.0] * 5
    features = torch.randn(5, 3, dtype=torch.float64, requires_grad=True)
    assert not potential("trees")(features).requires_grad


def test_badness_rises_with_the_potential(generator):
    fitted = potential("mlp")
    features = torch.randn(100, 3, generator=generator)
    order = fitted(features).argsort()
    badness = fitted.badness(features)[order].detach()
    assert bool((badness.diff() >= 0).all())
    assert 0 <= float(badness.min()) < float(badness.max()) <= 1


@pytest.mark.parametrize("shape", [(4, 2), (4, 4), (3,), (0, 2)])
def test_a_wrong_number_of_columns_is_refused(shape):
    with pytest.raises(ValueError, match=r"features of shape \(N, 3\), but got"):
        potential("linear")(torch.zeros(shape))


def test_a_mean_of_the_wrong_length_is_refused():
    with pytest.raises(ValueError, match=r"3 columns needs a mean .* shape \(2,\)"):
        Potential(COLUMNS, initialised(HEADS["linear"], 3, 0), torch.zeros(2), torch.ones(3))


def test_reading_potentials_does_not_import_lightning():
    script = "import sys, models.potentials.checkpoint; sys.exit('pytorch_lightning' in sys.modules)"
    root = Path(__file__).parents[3]
    assert subprocess.run([sys.executable, "-c", script], cwd=root, check=False).returncode == 0
