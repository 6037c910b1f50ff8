"""Random numbers that belong to a segment."""

from __future__ import annotations

import pytest
import torch

from blockstab.boxes.sampling import scramble, uniform


def splitmix64(state: int) -> int:
    """The published generator, one step, in unbounded integers."""
    mask = (1 << 64) - 1
    x = (state + 0x9E3779B97F4A7C15) & mask
    x = ((x ^ (x >> 30)) * 0xBF58476D1CE4E5B9) & mask
    x = ((x ^ (x >> 27)) * 0x94D049BB133111EB) & mask
    x ^= x >> 31
    return x - (1 << 64) if x >> 63 else x


def test_scramble_is_splitmix64(generator: torch.Generator) -> None:
    edges = torch.tensor([0, 1, -1, 2**63 - 1, -(2**63)])
    numbers = torch.cat([edges, torch.randint(-(2**62), 2**62, (1000,), generator=generator)])
    assert scramble(numbers).tolist() == [splitmix64(n % (1 << 64)) for n in numbers.tolist()]


def test_the_first_number_of_splitmix64_is_the_published_one() -> None:
    assert int(scramble(torch.tensor([0]))[0]) % (1 << 64) == 0xE220A8397B1DCDAF


def test_no_two_numbers_scramble_to_the_same() -> None:
    assert len(scramble(torch.arange(-100_000, 100_000)).unique()) == 200_000


def test_uniform_numbers_fill_the_unit_interval_evenly() -> None:
    numbers = uniform(torch.arange(50), 20_000, stream=0)
    assert numbers.dtype == torch.float64
    assert bool(((numbers >= 0) & (numbers < 1)).all())
    tenths = torch.bincount((numbers.flatten() * 10).long(), minlength=10)
    assert float((tenths / 100_000 - 1).abs().max()) < 0.015  # five standard deviations
    assert float(numbers.mean(dim=1).sub(0.5).abs().max()) < 0.011


def test_uniform_numbers_do_not_depend_on_the_other_seeds(generator: torch.Generator) -> None:
    seed = torch.randint(-(2**62), 2**62, (20,), generator=generator)
    together = uniform(seed, 100, stream=1)
    alone = torch.cat([uniform(one, 100, stream=1) for one in seed.split(1)])
    assert torch.equal(together, alone)
    assert torch.equal(uniform(seed, 30, stream=1), together[:, :30])


@pytest.mark.parametrize(("a", "b"), [((3, 0), (4, 0)), ((3, 0), (3, 1)), ((0, 1), (1, 0))])
def test_neighbouring_seeds_and_streams_have_nothing_in_common(
    a: tuple[int, int], b: tuple[int, int]
) -> None:
    one, other = (uniform(torch.tensor([seed]), 5000, stream)[0] for seed, stream in (a, b))
    assert not bool(torch.isin(one, other).any())
    assert abs(float(torch.corrcoef(torch.stack([one, other]))[0, 1])) < 0.07  # five standard deviations
