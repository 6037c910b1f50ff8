"""Scenes seen through smaller windows, so that the rim of the picture cuts things too."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import torch

from blockstab.datasets.sets import SceneSet
from blockstab.datasets.truth import MIN_VISIBLE_PX, Truth
from blockstab.rgbd.frame import Frame


@dataclass(frozen=True)
class CroppedScenes:
    """The scenes of another set, some of them cropped around their objects.

    Whoever makes pictures keeps things whole in them; whoever takes photographs does not. What learns from the first
    alone takes all that touches the rim for background.

    Args:
        whole: the other set.
        share: of the scenes that are cropped, drawn by `seed` and the scene's name.
        least: the side of a window, as a share of the picture's, is drawn between this and 1.
        seed: of all draws.

    Raises:
        ValueError: a share is not between 0 and 1.
    """

    whole: SceneSet
    share: float = 0.5
    least: float = 0.5
    seed: int = 0

    def __post_init__(self) -> None:
        if not 0.0 <= self.share <= 1.0 or not 0.0 < self.least <= 1.0:
            raise ValueError(
                f"Of the scenes a share of 0 to 1 is cropped, to sides of more than 0 and up to 1, but they are "
                f"{self.share} and {self.least}; choose others."
            )

    @property
    def name(self) -> str:
        """That of the other set, and how much of it is cropped."""
        return f"{self.whole.name}_cropped{self.share:g}"

    def scenes(self) -> list[str]:
        """Those of the other set."""
        return self.whole.scenes()

    def read(self, scene: str) -> tuple[Frame, Truth]:
        """One scene, cropped or not; what is left of an object may hardly be seen."""
        frame, truth = self.whole.read(scene)
        generator = self._generator(scene)
        if float(torch.rand((), generator=generator)) >= self.share:
            return frame, truth
        rows, columns = self._window(frame, truth, generator)
        cut = cropped(frame, rows, columns)
        assert cut.label is not None
        seen = torch.where(cut.depth > 0, cut.label, 0)
        objects = tuple(
            replace(o, hardly_seen=o.hardly_seen or int((seen == o.id).sum()) < MIN_VISIBLE_PX)
            for o in truth.objects
        )
        boundary = None if truth.boundary is None else truth.boundary[:, rows, columns].clone()
        if boundary is not None:
            # A pixel at the rim has no neighbour beyond it.
            boundary[0, :, -1] = False
            boundary[1, -1] = False
        return cut, replace(truth, objects=objects, boundary=boundary)

    def stamp(self, scene: str) -> str:
        """That of the other set, and what decides the window."""
        return f"{self.share} {self.least} {self.seed} {self.whole.stamp(scene)}"

    def official(self) -> Mapping[str, Sequence[str]]:
        """That of the other set."""
        return self.whole.official()

    def _generator(self, scene: str) -> torch.Generator:
        digest = hashlib.sha256(f"{self.seed} {scene}".encode()).digest()
        return torch.Generator().manual_seed(int.from_bytes(digest[:7]))

    def _window(self, frame: Frame, truth: Truth, generator: torch.Generator) -> tuple[slice, slice]:
        """Of the picture's shape, its middle somewhere between the objects' outermost pixels."""
        if frame.label is None:
            raise ValueError(f"{frame.name} has no label.png; a window is laid around objects.")
        side, down, right = torch.empty(3).uniform_(generator=generator).tolist()
        scale = self.least + (1.0 - self.least) * side
        things = torch.isin(frame.label, torch.tensor([o.id for o in truth.objects])).nonzero()
        middle = (things if len(things) else frame.label.new_zeros(1, 2)).double()
        low, high = middle.amin(dim=0), middle.amax(dim=0)
        slices = []
        for k, along in enumerate((down, right)):
            whole = frame.label.shape[k]
            length = max(1, round(scale * whole))
            start = round(float(low[k] + along * (high[k] - low[k])) - length / 2)
            start = min(max(start, 0), whole - length)
            slices.append(slice(start, start + length))
        return slices[0], slices[1]


def cropped(frame: Frame, rows: slice, columns: slice) -> Frame:
    """The part of a frame in these rows and columns, as a camera would see it that looks that way.

    Args:
        rows, columns: with a start each.
    """
    camera = replace(frame.camera, cx=frame.camera.cx - columns.start, cy=frame.camera.cy - rows.start)
    return replace(
        frame,
        color=frame.color[rows, columns].contiguous(),
        depth=frame.depth[rows, columns].contiguous(),
        label=None if frame.label is None else frame.label[rows, columns].contiguous(),
        camera=camera,
    )
