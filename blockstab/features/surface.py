"""Features of the surface of a segment: colours, facing, planes, height, and its shape in the image."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import torch
from kornia.color import rgb_to_ycbcr
from torch import Tensor

from blockstab.features.formulas import columns_of
from blockstab.observation import Observation
from blockstab.segments.atoms import Atoms

_COLORS = ("luma", "blue", "red")
_DIRECTIONS = 16  # of the lines that touch a segment in the image
_COUNTED = 0.1  # share of a segment's pixels on a plane that counts as one of its planes


@dataclass(frozen=True)
class _Measured:
    """Measurements of S segments."""

    pixels: Tensor  # (S,)
    area: Tensor  # (S,) square metres
    measured: Tensor  # (S,) pixels with depth
    flat: Tensor  # (S,) pixels in the ground plane
    planes: Tensor  # (S, P) share of the pixels on each plane
    deviation: Tensor  # (S, 3) of `_COLORS`
    contrast: Tensor  # (S, 3)
    facing: Tensor  # (S, 3) mean normal
    height: Tensor  # (S,) metres
    height_square: Tensor  # (S,)
    low: Tensor  # (S,)
    high: Tensor  # (S,)
    distance: Tensor  # (S,) metres
    elongation: Tensor  # (S,)
    hull_px: Tensor  # (S,)
    ellipse_px: Tensor  # (S,)


_Formula = Callable[[_Measured], Tensor]


def _deviation(k: int) -> _Formula:
    return lambda m: m.deviation[:, k]


def _contrast(k: int) -> _Formula:
    return lambda m: m.contrast[:, k]


_FORMULAS: dict[str, _Formula] = {
    "pixels_log": lambda m: m.pixels.log(),
    "area_log": lambda m: m.area.clamp(min=1e-9).log(),
    "measured_share": lambda m: m.measured / m.pixels,
    "ground_share": lambda m: m.flat / m.pixels,
    "plane_share": lambda m: m.planes.amax(dim=1),
    "plane_count": lambda m: (m.planes > _COUNTED).sum(dim=1),
    **{f"deviation_{color}": _deviation(k) for k, color in enumerate(_COLORS)},
    **{f"contrast_{color}": _contrast(k) for k, color in enumerate(_COLORS)},
    "facing_length": lambda m: m.facing.norm(dim=1),
    "facing_up": lambda m: m.facing[:, 1],
    "height_mean": lambda m: m.height,
    "height_deviation": lambda m: (m.height_square - m.height.square()).clamp(min=0.0).sqrt(),
    "height_least": lambda m: m.low,
    "height_greatest": lambda m: m.high,
    "distance": lambda m: m.distance,
    "elongation": lambda m: m.elongation,
    "fill_of_hull": lambda m: m.pixels / m.hull_px.clamp(min=1.0),
    "fill_of_ellipse": lambda m: m.pixels / m.ellipse_px.clamp(min=1.0),
}
SURFACE_COLUMNS = tuple(_FORMULAS)


class Surfaces:
    """Columns of the surface of any set of atoms.

    * `pixels_log`, `area_log`: logarithms of the pixels, and of their area in square metres, seen straight on.
    * `measured`, `ground`, `plane` share: of pixels with depth, in the ground plane, and on the largest plane;
      `plane_count`: planes that hold a tenth of the pixels.
    * `deviation`, `contrast`: standard deviation of a colour, and difference from the mean of the atoms around.
    * `facing_length`, `facing_up`: length and height of the mean normal.
    * `height`: above the ground, metres. `distance`: depth, metres.
    * `elongation`: ratio of the axes of the pixels' ellipse; `fill`: share of that ellipse, and of the polygon that
      16 lines around the segment make, that the segment's pixels fill.
    """

    def __init__(self, observation: Observation, atoms: Atoms) -> None:
        """Sum over the pixels of all atoms once."""
        from blockstab.features.compiled.members import borders_of

        inside = (atoms.label > 0).flatten()
        owner = atoms.label.flatten()[inside] - 1
        count = len(atoms)

        def summed(values: Tensor) -> Tensor:
            values = values.double()
            zeros = torch.zeros(count, *values.shape[1:], dtype=torch.float64)
            return zeros.index_add(0, owner, values)

        cloud = observation.cloud
        valid = cloud.valid.flatten()[inside].double()
        colors = summed(_moments(_ycbcr(observation.frame.color)[inside]))
        normals = cloud.normals.flatten(0, 1)[inside]
        facing = summed(torch.cat([normals, (normals != 0).any(dim=1, keepdim=True)], dim=1))
        ground = observation.ground.height
        height = cloud.points[..., 1].flatten()[inside] - (0.0 if ground is None else ground)
        depth = cloud.depth.flatten()[inside]
        flat = observation.on_ground.flatten()[inside]
        area = (depth / observation.frame.camera.fx) * (depth / observation.frame.camera.fy)
        parts = [valid, flat, valid * height, valid * height.square(), valid * depth, area]
        measured = summed(torch.stack([part.double() for part in parts], dim=1))
        reach = _reach(height, valid > 0, owner, count)
        plane = observation.planes.label.flatten()[inside]
        planes = torch.zeros(count, int(plane.max()) + 1 if len(plane) else 1, dtype=torch.float64)
        planes.index_put_((owner, plane), torch.ones(len(owner), dtype=torch.float64), accumulate=True)
        rows = inside.nonzero()[:, 0]
        width = atoms.label.shape[1]
        places = torch.stack([rows % width, rows // width], dim=1).double()
        moments = summed(torch.cat([places, places.square(), places.prod(dim=1, keepdim=True)], dim=1))
        pixels = atoms.pixel_count.double()[:, None]
        parts = [pixels, measured, colors, facing, moments, planes[:, 1:]]
        self._widths = [part.shape[1] for part in parts]
        self._summed = torch.cat(parts, dim=1).numpy()
        self._far = torch.cat([-reach[:, :1], reach[:, 1:], _support(places, owner, count)], dim=1).numpy()
        self._color = (colors[:, :3] / pixels).contiguous().numpy()
        self._borders = borders_of(atoms)

    def __call__(self, segments: Sequence[frozenset[int]]) -> Tensor:
        """Columns of S segments, (S, C) float64, in the order of `SURFACE_COLUMNS`."""
        # Importing numba takes half a second, and most of the package does without it.
        from blockstab.features.compiled.members import around, maxima, members_of, sums

        members = members_of(segments)
        summed = torch.from_numpy(sums(members, self._summed))
        pixels, measured, colors, facing, moments, planes = torch.split(summed, self._widths, dim=1)
        share = planes / pixels if planes.shape[1] else torch.zeros_like(pixels)
        known, flat, height, square, depth, area = measured.unbind(dim=1)
        measured_px = known.clamp(min=1.0)
        color = colors / pixels
        beside, length = map(torch.from_numpy, around(members, self._borders, self._color))
        low, high, *support = torch.from_numpy(maxima(members, self._far)).unbind(dim=1)
        elongation, ellipse = _ellipse(moments / pixels)
        found = _Measured(
            pixels=pixels[:, 0],
            area=area,
            measured=known,
            flat=flat,
            planes=share,
            deviation=(color[:, 3:] - color[:, :3].square()).clamp(min=0.0).sqrt(),
            contrast=torch.where(length[:, None] > 0, (color[:, :3] - beside).abs(), 0.0),
            facing=facing[:, :3] / facing[:, 3:].clamp(min=1.0),
            height=height / measured_px,
            height_square=square / measured_px,
            # 0 where nothing is measured.
            low=torch.where(low.isinf(), 0.0, -low),
            high=torch.where(high.isinf(), 0.0, high),
            distance=depth / measured_px,
            elongation=elongation,
            hull_px=_hull(torch.stack(support, dim=1)),
            ellipse_px=ellipse,
        )
        return columns_of(_FORMULAS, found)


def _ellipse(moments: Tensor) -> tuple[Tensor, Tensor]:
    """(S,) ratio of the short to the long axis of the ellipse with the pixels' moments (S, 5); (S,) its area."""
    x, y, xx, yy, xy = moments.unbind(dim=1)
    # A pixel is a square: of one alone, the variance is a twelfth.
    a, b, c = xx - x * x + 1 / 12, yy - y * y + 1 / 12, xy - x * y
    middle, spread = (a + b) / 2, ((a - b) / 2).square().add(c.square()).sqrt()
    short, long = (middle - spread).clamp(min=1 / 12).sqrt(), (middle + spread).sqrt()
    return short / long, 4 * math.pi * short * long


def _hull(reach: Tensor) -> Tensor:
    """(S,) area of the polygon of `_DIRECTIONS` lines that touch the pixels of a segment, as far out as (S, D)."""
    turn = 2 * math.pi / _DIRECTIONS
    after, before = reach.roll(-1, dims=1), reach.roll(1, dims=1)
    # Each side of the polygon, from where the neighbouring lines cut it, is the base of a triangle to the origin.
    side = (after + before - 2 * reach * math.cos(turn)) / math.sin(turn)
    return 0.5 * (side.clamp(min=0.0) * reach).sum(dim=1)


def _ycbcr(color: Tensor) -> Tensor:
    """(M, 3) float64 Y, Cb and Cr of an (H, W, 3) uint8 image, 0 to 1."""
    rgb = color.permute(2, 0, 1)[None].double() / 255.0
    ycbcr: Tensor = rgb_to_ycbcr(rgb)
    return ycbcr[0].flatten(1).T


def _moments(values: Tensor) -> Tensor:
    return torch.cat([values, values.square()], dim=1)


def _reach(height: Tensor, valid: Tensor, owner: Tensor, count: int) -> Tensor:
    """(A, 2) the least and the greatest height of each atom; infinite where nothing is measured."""
    low = torch.full((count,), torch.inf, dtype=torch.float64)
    high = torch.full((count,), -torch.inf, dtype=torch.float64)
    low = low.scatter_reduce(0, owner[valid], height[valid], "amin")
    return torch.stack([low, high.scatter_reduce(0, owner[valid], height[valid], "amax")], dim=1)


def _support(places: Tensor, owner: Tensor, count: int) -> Tensor:
    """(A, D) how far the pixels of each atom reach in each direction, to their rims."""
    angle = torch.arange(_DIRECTIONS, dtype=torch.float64) * (2 * math.pi / _DIRECTIONS)
    unit = torch.stack([angle.cos(), angle.sin()])
    reach = places @ unit + 0.5 * unit.abs().sum(dim=0)
    far = torch.full((count, _DIRECTIONS), -torch.inf, dtype=torch.float64)
    return far.scatter_reduce(0, owner[:, None].expand(-1, _DIRECTIONS), reach, "amax")
