"""Where boundaries are strong, and where they must stay weak."""

from __future__ import annotations

from dataclasses import replace

import pytest
import torch
from torch import Tensor
from torch.nn.functional import max_pool2d

from blockstab.boundaries.cues import CUES, Cues, cues_of
from blockstab.boundaries.edge_models import FixedWeights, LogisticWeights
from blockstab.rgbd.frame import Frame
from tests.block_scene import APART, STACK, TABLE, picture


def strength_of(frame: Frame) -> Tensor:
    return FixedWeights()(cues_of(frame)).strength


def one_cue(name: str, channel: int, value: float = 1.0) -> Cues:
    """A picture in which one cue of an edge is seen at its middle pixel."""
    values = torch.zeros(len(CUES), 4, 5, 7)
    values[CUES.index(name), channel, 2, 3] = value
    return Cues(values)


def inside(label: Tensor, number: int, reach_px: int) -> Tensor:
    """Pixels of one label, farther than `reach_px` from any other."""
    others = max_pool2d((label != number).double()[None], 2 * reach_px + 1, stride=1, padding=reach_px)[0] > 0
    return (label == number) & ~others


def outline(label: Tensor, number: int) -> Tensor:
    """Pixels of one label that touch another."""
    return (label == number) & ~inside(label, number, 1)


def around(mask: Tensor, value: Tensor, reach_px: int = 2) -> Tensor:
    """The greatest value near each pixel of the mask."""
    return max_pool2d(value[None], 2 * reach_px + 1, stride=1, padding=reach_px)[0][mask]


def test_strength_lies_between_zero_and_one() -> None:
    strength = strength_of(picture(STACK).frame)
    assert strength.dtype == torch.float64
    assert strength.shape == (240, 320)
    assert float(strength.min()) >= 0.0
    assert float(strength.max()) == 1.0


@pytest.mark.parametrize("blocks", [APART, STACK], ids=["apart", "stack"])
def test_blocks_are_outlined_by_strong_edges(blocks) -> None:
    scene = picture(blocks)
    for number in (2, 3):
        edge = outline(scene.frame.label, number)
        share = (around(edge, strength_of(scene.frame)) > 0.6).double().mean()
        assert share > 0.95


def test_a_convex_edge_and_print_are_weak_inside_a_block() -> None:
    scene = picture(APART)
    strength = strength_of(scene.frame)
    for number in (2, 3):
        assert float(strength[inside(scene.frame.label, number, 6)].max()) < 0.35


def test_the_foot_of_a_block_is_strong_without_any_colour() -> None:
    scene = picture(APART)
    grey = replace(scene.frame, color=torch.full_like(scene.frame.color, 120))
    strength = strength_of(grey)
    label = scene.frame.label
    foot = (label[:-1] > TABLE) & (label[1:] == TABLE)
    assert int(foot.sum()) > 50
    assert float(around(torch.nn.functional.pad(foot, (0, 0, 0, 1)), strength).min()) > 0.6


@pytest.mark.parametrize(("size", "edge"), [(3, False), (30, True)])
def test_only_large_areas_without_depth_have_a_rim(size: int, edge: bool) -> None:
    scene = picture(())
    depth = scene.frame.depth.clone()
    depth[150 : 150 + size, 150 : 150 + size] = 0.0
    frame = replace(scene.frame, depth=depth)
    strength = strength_of(frame)
    ring = strength[145 : 155 + size, 145 : 155 + size]
    assert (float(ring.max()) == 1.0) is edge


def test_a_narrow_shadow_between_two_surfaces_is_an_edge() -> None:
    scene = picture(())
    depth = scene.frame.depth.clone()
    depth[:, 160:] -= 0.1
    depth[:, 158:162] = 0.0
    frame = replace(scene.frame, depth=depth.clamp(min=0.0))
    strength = strength_of(frame)
    assert float(strength[100:200, 158:162].amax(dim=1).min()) == 1.0


@pytest.mark.parametrize("name", ["depth", "concave", "rim"])
def test_signs_of_geometry_count_in_full_and_in_their_own_orientation(name: str) -> None:
    found = FixedWeights()(one_cue(name, 2, 0.8))
    assert float(found.oriented[2, 2, 3]) == pytest.approx(0.8)
    assert float(found.strength[2, 3]) == pytest.approx(0.8)
    others = found.oriented.clone()
    others[2, 2, 3] = 0.0
    assert float(others.max()) < 0.01


def test_a_convex_crease_is_no_boundary_by_fixed_weights_but_may_be_by_learned_ones() -> None:
    cues = one_cue("convex", 1)
    assert float(FixedWeights()(cues).strength.max()) < 0.01
    learned = LogisticWeights([5.0 if name == "convex" else 0.0 for name in CUES], -2.5)(cues)
    assert float(learned.oriented[1, 2, 3]) == pytest.approx(1 / (1 + 2.718281828459045**-2.5), abs=1e-6)
    assert float(learned.oriented[0, 2, 3]) == pytest.approx(1 / (1 + 2.718281828459045**2.5), abs=1e-6)


def test_colour_alone_reaches_its_share_and_no_more() -> None:
    values = torch.zeros(len(CUES), 4, 5, 7)
    values[:4] = 1.0
    assert float(FixedWeights(0.4)(Cues(values)).strength.max()) == pytest.approx(0.4, abs=0.01)
    assert float(FixedWeights(0.0)(Cues(values)).strength.max()) == 0.0


@pytest.mark.parametrize("share", [-0.1, 1.1, float("nan")])
def test_a_share_that_is_none_is_refused(share: float) -> None:
    with pytest.raises(ValueError, match="between 0 and 1"):
        FixedWeights(share)


def test_every_cue_needs_a_weight() -> None:
    with pytest.raises(ValueError, match=r"brightness, color_a, .* but there are 3"):
        LogisticWeights([1.0, 2.0, 3.0], 0.0)
