"""The contract that every head keeps, and the potential around it."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest
import torch

from models.checkpoint import load_potentials, save_potentials
from models.heads import CLIP, HEADS, Potential, initialised

COLUMNS = ("volume", "tilt", "density")


def potential(name: str, seed: int = 0) -> Potential:
    head = initialised(HEADS[name], len(COLUMNS), seed)
    return Potential(
        COLUMNS, head, torch.tensor([1.0, 2.0, 3.0]), torch.tensor([1.0, 0.5, 2.0]), a=4.0, b=-2.0
    )


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


@every_head
def test_gradients_reach_the_features_and_every_parameter(name, generator):
    fitted = potential(name)
    features = torch.randn(50, 3, generator=generator, dtype=torch.float64, requires_grad=True)
    fitted(features).sum().backward()
    assert bool((features.grad.abs().sum(dim=0) > 0).all())
    assert all(p.grad is not None and bool((p.grad != 0).any()) for p in fitted.head.parameters())


@every_head
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
    kept = {"unary": potential(name), "pairwise": potential(name, seed=1)}
    save_potentials(tmp_path / "mine", kept, {})
    loaded = load_potentials(tmp_path / "mine.json")
    features = torch.randn(40, 3, generator=generator, dtype=torch.float64)
    for kind, saved in kept.items():
        read = getattr(loaded, kind)
        assert torch.equal(read(features), saved(features))
        assert torch.equal(read.badness(features), saved.badness(features))
        assert read.columns == COLUMNS


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
    script = "import sys, models.checkpoint; sys.exit('pytorch_lightning' in sys.modules)"
    root = Path(__file__).parents[2]
    assert subprocess.run([sys.executable, "-c", script], cwd=root, check=False).returncode == 0
