"""An image made ready to be understood: points, ground, atoms, and a first segmentation."""

from __future__ import annotations

from dataclasses import dataclass

import torch
from torch import Tensor

from blockstab.observation import Observation
from blockstab.proposals import Proposal, Proposed
from blockstab.rgbd.occlusion import Occlusion
from blockstab.segments.atoms import Atoms, join, make_atoms
from blockstab.segments.segmentation import Segment, Segmentation


@dataclass(frozen=True)
class SearchInput:
    """An image made ready: what it shows, its finest partition, and where to start.

    Args:
        observation: the image, its points in the world frame, and the ground.
        atoms: the finest partition; every proposed region is a set of atoms.
        start: the proposal as a segmentation, which tells what the proposal knows of background.
        label: (H, W) int64 the proposal's ids on the pixels of `start`.
    """

    observation: Observation
    atoms: Atoms
    start: Segmentation
    label: Tensor

    @property
    def occlusion(self) -> Occlusion:
        """Occlusion: what the camera saw, and what was hidden from it."""
        frame = self.observation.frame
        return Occlusion(frame.depth, frame.camera, self.observation.ground.world_from_camera)


def make_search_input(observation: Observation, proposal: Proposal) -> SearchInput:
    """Prepare an image for understanding.

    Raises:
        ValueError: if the proposal leaves no region with depth.
    """
    proposed, fine = proposal(observation), observation.fine
    label = torch.where(fine > 0, proposed.label, 0)
    partition = _with_depth(join(fine, label), observation.cloud.valid)
    if not bool(partition.any()):
        raise ValueError(f"{observation.frame.name}: the proposal leaves no region with depth.")
    atoms = make_atoms(partition, observation.boundary_map.strength)
    label = torch.where(atoms.label > 0, label, 0)
    start = Segmentation.from_labels(atoms, label)
    return SearchInput(observation, atoms, start.telling(_known(start, atoms, label, proposed)), label)


def _with_depth(partition: Tensor, valid: Tensor) -> Tensor:
    """The partition without the parts that hold no measured pixel, numbered from 1 without gaps."""
    measured = torch.bincount(partition[valid], minlength=int(partition.max()) + 1) > 0
    measured[0] = False
    number = measured.cumsum(dim=0) * measured
    return number[partition]


def _known(start: Segmentation, atoms: Atoms, label: Tensor, proposed: Proposed) -> dict[Segment, bool]:
    of_atom = torch.zeros(len(atoms), dtype=torch.int64)
    inside = atoms.label > 0
    of_atom[atoms.label[inside] - 1] = label[inside]
    ids = {segment: int(of_atom[min(segment)]) for segment in start.segments}
    return {segment: proposed.is_background[i] for segment, i in ids.items() if i in proposed.is_background}
