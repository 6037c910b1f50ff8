"""The sides of pixels, one after the other, as a reference for what is summed over borders all at once."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np
from torch import Tensor

from blockstab.boundaries.cues import CUES
from blockstab.observation import Observation
from blockstab.rgbd.noise import KINECT

Pixel = tuple[int, int]


def sides(label: Tensor) -> Iterator[tuple[Pixel, Pixel]]:
    """Every pair of pixels of an image that share a side."""
    height, width = label.shape
    for row in range(height):
        for column in range(width):
            if column + 1 < width:
                yield (row, column), (row, column + 1)
            if row + 1 < height:
                yield (row, column), (row + 1, column)


@dataclass
class Around:
    """What the sides of pixels around and in a set of atoms show.

    Args:
        border: to each pair of one atom within and one outside, the strengths of the sides between them.
        inner: likewise, of two atoms within.
        cues, inner_cues: of each side, in the order of `BORDER_CUES`.
        before, behind, blank, rim: how many sides are so.
    """

    border: dict[tuple[int, int], list[float]] = field(default_factory=lambda: defaultdict(list))
    inner: dict[tuple[int, int], list[float]] = field(default_factory=lambda: defaultdict(list))
    cues: list[np.ndarray] = field(default_factory=list)
    inner_cues: list[np.ndarray] = field(default_factory=list)
    before: int = 0
    behind: int = 0
    blank: int = 0
    rim: int = 0


def around(observation: Observation, label: Tensor, segment: frozenset[int]) -> Around:
    """Look at all sides in turn."""
    found, images = Around(), border_images(observation)
    numbers, depth = label.numpy(), observation.cloud.depth.numpy()
    height, width = numbers.shape
    for row, column in np.argwhere(np.isin(numbers - 1, list(segment))):
        found.rim += (row in (0, height - 1)) + (column in (0, width - 1))
    for one, other in sides(label):
        a, b = int(numbers[one]) - 1, int(numbers[other]) - 1
        if a == b or (a not in segment and b not in segment):
            continue
        if a < 0 or b < 0:
            found.blank += 1
            continue
        seen = np.maximum(images[:, *one], images[:, *other])
        if a in segment and b in segment:
            found.inner[min(a, b), max(a, b)].append(seen[0])
            found.inner_cues.append(seen)
            continue
        within, outside = (one, other) if a in segment else (other, one)
        found.border[int(numbers[within]) - 1, int(numbers[outside]) - 1].append(seen[0])
        found.cues.append(seen)
        near, far = depth[within], depth[outside]
        if near > 0 and far > 0:
            step = max(0.01, 2 * KINECT.step * max(near, far) ** 2)
            found.before += far - near > step
            found.behind += near - far > step
    return found


def border_images(observation: Observation) -> np.ndarray:
    """(7, H, W) the images of `BORDER_CUES`."""
    cues = dict(zip(CUES, observation.cues.double().numpy(), strict=True))
    color = np.maximum(cues["color_a"], cues["color_b"])
    rest = [cues[name] for name in ("texture", "depth", "convex", "concave")]
    return np.stack([observation.boundary_map.strength.numpy(), cues["brightness"], color, *rest])


def groups(atoms: frozenset[int], links: list[tuple[int, int]]) -> list[set[int]]:
    """The atoms that links hold together."""
    parts = [{atom} for atom in sorted(atoms)]
    for a, b in links:
        one, other = (next(p for p in parts if atom in p) for atom in (a, b))
        if one is not other:
            one |= other
            parts.remove(other)
    return parts
