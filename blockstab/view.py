"""An image made ready to be understood: points, ground, atoms, and a first segmentation."""

from __future__ import annotations

from dataclasses import dataclass

import torch
from torch import Tensor

from blockstab.percept import Percept
from blockstab.proposals import Proposal, Proposed
from blockstab.rgbd.sight import Sight
from blockstab.segments.atoms import Atoms, join, make_atoms
from blockstab.segments.segmentation import Segment, Segmentation


@dataclass(frozen=True)
class View:
    """An image made ready: what it shows, its finest partition, and where to start.

    Args:
        percept: the image, its points in the world frame, and the ground.
        atoms: the finest partition; every proposed region is a set of atoms.
        start: the proposal as a segmentation, which tells what the proposal knows of background.
        label: (H, W) int64 the proposal's ids on the pixels of `start`.
    """

    percept: Percept
    atoms: Atoms
    start: Segmentation
    label: Tensor

    @property
    def sight(self) -> Sight:
        """What the camera saw, and what was hidden from it."""
        frame = self.percept.frame
        return Sight(frame.depth, frame.camera, self.percept.ground.world_from_camera)


def make_view(percept: Percept, proposal: Proposal) -> View:
    """Prepare an image for understanding.

    Raises:
        ValueError: if the proposal leaves no region with depth.
    """
    proposed, fine = proposal(percept), percept.fine
    label = torch.where(fine > 0, proposed.label, 0)
    partition = _with_depth(join(fine, label), percept.cloud.valid)
    if not bool(partition.any()):
        raise ValueError(f"{percept.frame.name}: the proposal leaves no region with depth.")
    atoms = make_atoms(partition, percept.boundaries.strength)
    label = torch.where(atoms.label > 0, label, 0)
    start = Segmentation.from_labels(atoms, label)
    return View(percept, atoms, start.telling(_known(start, atoms, label, proposed)), label)


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
    return {segment: proposed.known[i] for segment, i in ids.items() if i in proposed.known}
