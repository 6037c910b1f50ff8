import torch

from blockstab.stability.support import GROUND, SupportType
from blockstab.testing import worlds
from blockstab.testing.worlds import TABLE, judge


def test_the_side_support_of_touching_neighbours_is_trimmed():
    verdict = judge(*worlds.TOUCHING_NEIGHBOURS)
    assert (verdict.candidates.type == SupportType.SIDE).sum() == 2
    assert verdict.supporters(0) == {TABLE}
    assert verdict.supporters(1) == {TABLE}


def test_a_plank_leaning_on_a_wall_needs_both_the_floor_and_the_wall():
    verdict = judge(*worlds.LEANING_PLANK)
    assert verdict.supporters(0) == {(GROUND, "partial"), (1, "side")}
    assert verdict.balance.stable.tolist() == [True, True]


def test_a_leaning_plank_falls_without_its_wall():
    verdict = judge(worlds.LEANING_PLANK[0])
    assert verdict.balance.stable.tolist() == [False]


def test_two_planks_that_lean_on_each_other_both_stand():
    verdict = judge(*worlds.TENT)
    assert verdict.balance.stable.tolist() == [True, True]
    assert verdict.supporters(0) == {(GROUND, "partial"), (1, "side")}
    assert verdict.supporters(1) == {(GROUND, "partial"), (0, "side")}


def test_where_nothing_makes_a_box_stand_all_its_supports_are_kept():
    blocks = (*worlds.overhang(0.03), worlds.Block(0.14, 0.0, 0.02, 0.21, z=0.3))
    verdict = judge(*blocks)
    mine = verdict.candidates.supported == 1
    assert verdict.supporters(1) == {
        (int(s), SupportType(int(t)).name.lower())
        for s, t in zip(verdict.candidates.supporter[mine], verdict.candidates.type[mine], strict=True)
    }
    assert not bool(verdict.balance.stable[1])


def test_trimming_adds_no_support_and_topples_nothing():
    generator = torch.Generator().manual_seed(3)
    for _ in range(30):
        x = torch.rand(6, generator=generator) * 0.4 - 0.2
        blocks = [worlds.Block(float(x[k]), 0.1 * (k // 2), 0.2, 0.1) for k in range(6)]
        verdict = judge(*blocks)
        kept = set(zip(verdict.supports.supporter.tolist(), verdict.supports.supported.tolist(), strict=True))
        all_ = set(
            zip(verdict.candidates.supporter.tolist(), verdict.candidates.supported.tolist(), strict=True)
        )
        assert kept <= all_
