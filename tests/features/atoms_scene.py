"""Made-up images in many small parts, and segments that are made up of these."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import torch
from torch import Tensor

from blockstab.observation import Observation
from blockstab.segments.atoms import Atoms, make_atoms
from blockstab.segments.segmentation import Pair, Segment, Segmentation
from tests.features.observed import HEIGHT, WIDTH, cells, cluttered

SEGMENTS = 7


def clutter(generator: torch.Generator, unlabelled: bool = False) -> tuple[Observation, Atoms]:
    """Large atoms among small ones, which meet in all ways; some pixels have no depth, some may have no label."""
    label = cells(15, generator)
    small = torch.randint(2, (8, 12), generator=generator).bool()
    tiles = label.max() + 1 + torch.arange(small.numel()).view_as(small)
    tiles = torch.where(small, tiles, 0).repeat_interleave(3, 0).repeat_interleave(2, 1)
    label[18:42, 20:44] = torch.where(tiles > 0, tiles, label[18:42, 20:44])
    label = torch.unique(label, return_inverse=True)[1]
    atoms = torch.where(label == 3, 0, label) if unlabelled else label
    atoms = torch.unique(atoms, return_inverse=True)[1] + (0 if unlabelled else 1)
    observation = cluttered(label + 1, generator)
    holes = torch.rand(HEIGHT, WIDTH, generator=generator) < 0.1
    valid = observation.cloud.valid & ~holes
    cloud = type(observation.cloud)(
        observation.cloud.points * valid[..., None],
        observation.cloud.normals * valid[..., None],
        valid,
        observation.cloud.depth * valid,
    )
    observation = replace(observation, cloud=cloud)
    return observation, make_atoms(atoms, observation.boundary_map.strength)


def grouped(atoms: Atoms, generator: torch.Generator) -> Segmentation:
    """Atoms gathered at random, near and far."""
    part = torch.randint(SEGMENTS, (len(atoms),), generator=generator)
    part[:SEGMENTS] = torch.arange(SEGMENTS)
    parts = [frozenset((part == k).nonzero()[:, 0].tolist()) for k in range(SEGMENTS)]
    return Segmentation(tuple(sorted(parts, key=min)))


def renamed(
    observation: Observation, atoms: Atoms, segments: Sequence[Segment], generator: torch.Generator
) -> tuple[Atoms, list[Segment]]:
    """The same atoms under other names, and the same segments of them."""
    order = torch.randperm(len(atoms), generator=generator)
    number = torch.cat([torch.zeros(1, dtype=torch.int64), order + 1])
    named = make_atoms(number[atoms.label], observation.boundary_map.strength)
    return named, [frozenset(order[sorted(segment)].tolist()) for segment in segments]


def neighbours(segmentation: Segmentation, atoms: Atoms) -> list[Pair]:
    """All pairs of segments that share a border."""
    first, second = segmentation.neighbours(atoms, min_border_px=1)
    segments = segmentation.segments
    return [(segments[i], segments[j]) for i, j in zip(first.tolist(), second.tolist(), strict=True)]


def as_two(pair: Pair, atoms: Atoms) -> Tensor:
    """(H, W) labels: 1 and 2 for the pair, 3 for all else."""
    kind = torch.full((len(atoms) + 1,), 3)
    for number, segment in enumerate(pair, start=1):
        kind[torch.tensor(sorted(segment)) + 1] = number
    return kind[atoms.label]
