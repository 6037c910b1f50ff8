"""Brightness, colour and texture gradients of whole images, and their combination."""

from __future__ import annotations

from collections.abc import Iterator

import pytest
import torch
from torch import Tensor

from blockstab.boundaries.gradients import COLOR_GRADIENTS, color_gradients, pb
from tests.tolerance import HISTOGRAM, LEARNED

BRIGHTNESS, COLOR_A, COLOR_B, TEXTURE = range(4)
SIZE = 96
EDGES = {0: "-", 1: "/", 2: "|", 3: "\\"}
SIZES = [(1, 1), (1, 9), (10, 7), (37, 50)]


def offset(orientation: int) -> Tensor:
    """(96, 96) int64: above 0 on one side of a line through the middle of the image, at most 0 on the other."""
    row, column = torch.meshgrid(torch.arange(1, SIZE + 1), torch.arange(1, SIZE + 1), indexing="ij")
    return (row - SIZE // 2, row + column - SIZE, column - SIZE // 2, row - column)[orientation]


def two_colors(orientation: int, one: tuple[int, int, int], other: tuple[int, int, int]) -> Tensor:
    side = (offset(orientation) > 0)[..., None]
    return torch.where(side, torch.tensor(one), torch.tensor(other)).to(torch.uint8)


def noise(height: int, width: int, generator: torch.Generator) -> Tensor:
    """Patches and grain of many colours."""
    coarse = torch.rand(1, 3, 6, 6, generator=generator)
    patches = torch.nn.functional.interpolate(coarse, size=(height, width), mode="nearest")[0]
    grain = 0.1 * torch.randn(3, height, width, generator=generator)
    return ((patches + grain).clamp(0.0, 1.0) * 255).permute(1, 2, 0).to(torch.uint8)


def stripes(slope: Tensor | int) -> Tensor:
    """(96, 96, 3): diagonal stripes of a period of 6 pixels; `slope` is 1 for "/" and -1 for "\\"."""
    row, column = torch.meshgrid(torch.arange(SIZE), torch.arange(SIZE), indexing="ij")
    wave = torch.sin(torch.pi / 3 * (column + slope * row) / 2**0.5)
    return (128 + 60 * wave).round().to(torch.uint8)[..., None].expand(-1, -1, 3)


@pytest.mark.parametrize("orientation", EDGES, ids=EDGES.values())
@pytest.mark.parametrize(
    ("gradient", "one", "other"),
    [
        (BRIGHTNESS, (40, 40, 40), (90, 90, 90)),
        (COLOR_A, (170, 60, 60), (60, 110, 60)),
        (COLOR_B, (150, 150, 60), (130, 130, 190)),
        (TEXTURE, (40, 40, 40), (90, 90, 90)),
    ],
    ids=COLOR_GRADIENTS,
)
def test_a_step_is_strongest_where_it_is_and_along_itself(
    gradient: int, one: tuple[int, int, int], other: tuple[int, int, int], orientation: int
) -> None:
    found = color_gradients(two_colors(orientation, one, other))[gradient]
    away = offset(orientation) - 0.5  # rows or columns, of diagonal steps their sum
    inner = torch.zeros(SIZE, SIZE, dtype=torch.bool)
    inner[20:-20, 20:-20] = True
    on_edge = found[:, inner & (away.abs() < 1)]
    assert bool((on_edge.argmax(dim=0) == orientation).all())
    assert float(on_edge[orientation].min()) > 0.3
    assert float(found[:, inner & (away.abs() > 27)].max()) < 0.02
    if gradient == TEXTURE:  # textons change again where the step is out of their sight
        assert float(on_edge[orientation].min()) > 0.7
    else:
        within_a_pixel = found[orientation, inner & (away.abs() < 2)]
        assert float(within_a_pixel.max()) >= float(found[:, inner].max()) - LEARNED


def test_black_beside_white_nearly_fills_the_scale() -> None:
    found = color_gradients(two_colors(2, (0, 0, 0), (255, 255, 255)))
    assert 0.65 < float(found[BRIGHTNESS].max()) < 1.0
    assert float(found[COLOR_A : COLOR_B + 1].max()) == 0.0
    assert float(pb(found)[2].max()) > 0.8


def test_colors_of_equal_lightness_differ_without_any_brightness_or_texture() -> None:
    found = color_gradients(two_colors(2, (170, 60, 60), (60, 111, 60)))[:, 2, SIZE // 2].amax(dim=1)
    assert float(found[COLOR_A]) > 0.8
    assert float(found[BRIGHTNESS]) < 0.1


def test_stripes_of_two_orientations_meet_in_a_texture_edge_and_no_brightness_edge() -> None:
    slope = torch.where(torch.arange(SIZE) < SIZE // 2, 1, -1)
    found = color_gradients(stripes(slope))
    edge = found[:, :, 20:-20, SIZE // 2 - 1 : SIZE // 2 + 1]
    inside = found[:, :, 20:-20, 14:30]
    assert float(edge[TEXTURE, 2].min()) > 0.6
    assert bool((edge[TEXTURE].argmax(dim=0) == 2).all())
    assert float(inside[TEXTURE].max()) < 0.2
    assert float(edge[BRIGHTNESS].max()) < 0.1


@pytest.mark.parametrize("size", SIZES)
@pytest.mark.parametrize("color", [(0, 0, 0), (255, 255, 255), (200, 30, 90)])
def test_a_plain_image_has_no_gradient(color: tuple[int, int, int], size: tuple[int, int]) -> None:
    found = color_gradients(torch.tensor(color, dtype=torch.uint8).expand(*size, 3))
    assert found.dtype == torch.float32
    assert found.shape == (len(COLOR_GRADIENTS), 4, *size)
    assert bool((found == 0.0).all())


@pytest.mark.parametrize("size", SIZES)
def test_gradients_of_any_image_lie_between_zero_and_one(
    size: tuple[int, int], generator: torch.Generator
) -> None:
    for color in (noise(*size, generator), 255 * torch.randint(0, 2, (*size, 3), generator=generator).byte()):
        found = color_gradients(color)
        assert bool(found.isfinite().all())
        assert float(found.min()) >= 0.0
        assert float(found.max()) <= 1.0 + LEARNED


def test_the_rim_of_a_picture_is_no_edge() -> None:
    ramp = (torch.arange(SIZE) * 2 + 20).to(torch.uint8)[None, :, None].expand(SIZE, -1, 3)
    found = color_gradients(ramp)
    inside = found[:, :, 20:-20, 20:-20].amax(dim=(2, 3))
    assert bool((found.amax(dim=(2, 3)) <= inside + HISTOGRAM).all())


def test_a_quarter_turn_of_the_picture_turns_every_gradient(generator: torch.Generator) -> None:
    color = noise(60, 84, generator)
    turned = color_gradients(torch.rot90(color, 1, (0, 1)))
    expected = torch.rot90(color_gradients(color), 1, (2, 3))[:, [2, 3, 0, 1]]
    assert turned[:TEXTURE].numpy() == pytest.approx(expected[:TEXTURE].numpy(), abs=LEARNED)
    # Where two filters answer all but equally, the first one may win here and the second one there.
    same = (turned[TEXTURE] - expected[TEXTURE]).abs() < LEARNED
    assert float(same.double().mean()) > 0.95


@pytest.fixture
def threads() -> Iterator[None]:
    before = torch.get_num_threads()
    yield
    torch.set_num_threads(before)


@pytest.mark.usefixtures("threads")
@pytest.mark.parametrize("size", [(1, 3), (243, 317), (371, 375)])
def test_the_number_of_threads_changes_no_bit(size: tuple[int, int], generator: torch.Generator) -> None:
    color = noise(*size, generator)
    answers = []
    for count in (1, 2):
        torch.set_num_threads(count)
        gradients = color_gradients(color)
        answers.append((gradients, pb(gradients)))
    assert all(torch.equal(one, two) for one, two in zip(*answers, strict=True))


def test_without_gradients_a_boundary_is_improbable_and_every_gradient_makes_it_less_so() -> None:
    none = torch.zeros(4, 4, 2, 3)
    assert pb(none).numpy() == pytest.approx(0.01099, abs=LEARNED)
    for k in range(4):
        some = none.clone()
        some[k, 1] = 0.5
        assert bool((pb(some)[1] > 0.03).all())
        assert bool((pb(some)[[0, 2, 3]] == pb(none)[0]).all())
