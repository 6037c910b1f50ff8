"""Where edges are strong, and where they must stay weak."""

from __future__ import annotations

from dataclasses import replace

import pytest
import torch
from torch import Tensor
from torch.nn.functional import max_pool2d

from blockstab.rgbd.cloud import cloud_from_frame
from blockstab.segments.boundaries import boundary_strength
from tests.block_scene import APART, STACK, TABLE, Picture, picture


def strength_of(scene: Picture) -> Tensor:
    return boundary_strength(scene.frame, scene.cloud)


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
    strength = strength_of(picture(STACK))
    assert strength.dtype == torch.float64
    assert strength.shape == (240, 320)
    assert float(strength.min()) >= 0.0
    assert float(strength.max()) == 1.0


@pytest.mark.parametrize("blocks", [APART, STACK], ids=["apart", "stack"])
def test_blocks_are_outlined_by_strong_edges(blocks) -> None:
    scene = picture(blocks)
    for number in (2, 3):
        edge = outline(scene.frame.label, number)
        share = (around(edge, strength_of(scene)) > 0.6).double().mean()
        assert share > 0.95


def test_a_convex_edge_and_print_are_weak_inside_a_block() -> None:
    scene = picture(APART)
    strength = strength_of(scene)
    for number in (2, 3):
        assert float(strength[inside(scene.frame.label, number, 6)].max()) < 0.35


def test_the_foot_of_a_block_is_strong_without_any_colour() -> None:
    scene = picture(APART)
    grey = replace(scene.frame, color=torch.full_like(scene.frame.color, 120))
    strength = boundary_strength(grey, scene.cloud)
    label = scene.frame.label
    foot = (label[:-1] > TABLE) & (label[1:] == TABLE)
    assert int(foot.sum()) > 50
    assert float(around(torch.nn.functional.pad(foot, (0, 0, 0, 1)), strength).min()) > 0.6


def test_strength_does_not_depend_on_the_frame_of_the_points() -> None:
    scene = picture(STACK)
    turned = boundary_strength(scene.frame, cloud_from_frame(scene.frame))
    # Single precision inside: a rotation moves the last bits of the points.
    assert torch.allclose(turned, strength_of(scene), atol=0.02)


@pytest.mark.parametrize(("size", "edge"), [(3, False), (30, True)])
def test_only_large_areas_without_depth_have_a_rim(size: int, edge: bool) -> None:
    scene = picture(())
    depth = scene.frame.depth.clone()
    depth[150 : 150 + size, 150 : 150 + size] = 0.0
    frame = replace(scene.frame, depth=depth)
    strength = boundary_strength(frame, cloud_from_frame(frame))
    ring = strength[145 : 155 + size, 145 : 155 + size]
    assert (float(ring.max()) == 1.0) is edge


def test_a_narrow_shadow_between_two_surfaces_is_an_edge() -> None:
    scene = picture(())
    depth = scene.frame.depth.clone()
    depth[:, 160:] -= 0.1
    depth[:, 158:162] = 0.0
    frame = replace(scene.frame, depth=depth.clamp(min=0.0))
    strength = boundary_strength(frame, cloud_from_frame(frame))
    assert float(strength[100:200, 158:162].amax(dim=1).min()) == 1.0
