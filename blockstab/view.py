"""An image made ready to be understood: points, ground, atoms, and a first segmentation."""

from __future__ import annotations

from dataclasses import dataclass

import torch
from torch import Tensor

from blockstab.percept import Percept
from blockstab.proposals import Proposal, Proposed
from blockstab.rgbd.sight import Sight
from blockstab.segments.atoms import Atoms, join, make_atoms
from blockstab.segments.segmentation import Segmentation


@dataclass(frozen=True)
class View:
    """An image made ready: what it shows, its finest partition, and where to start.

    Args:
        percept: the image, its points in the world frame, and the ground.
        atoms: the finest partition; every proposed region is a set of atoms.
        start: the proposal as a segmentation.
        label: (H, W) int64 the proposal's ids on the pixels of `start`.
        known: (A,) int64, 1 for atoms of known background, 0 for atoms of known objects, -1 for the rest.
    """

    percept: Percept
    atoms: Atoms
    start: Segmentation
    label: Tensor
    known: Tensor

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
    return View(percept, atoms, start, label, _known(atoms, label, proposed))


def _with_depth(partition: Tensor, valid: Tensor) -> Tensor:
    """The partition without the parts that hold no measured pixel, numbered from 1 without gaps."""
    measured = torch.bincount(partition[valid], minlength=int(partition.max()) + 1) > 0
    measured[0] = False
    number = measured.cumsum(dim=0) * measured
    return number[partition]


def _known(atoms: Atoms, label: Tensor, proposed: Proposed) -> Tensor:
    known = torch.full((len(atoms),), -1, dtype=torch.long)
    for identity, background in proposed.known.items():
        known[atoms.label[label == identity] - 1] = int(background)
    return known
