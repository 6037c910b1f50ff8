"""Everything one parse produced: what a program reads, what a report shows."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from torch import Tensor

from blockstab.boxes.box import Boxes
from blockstab.parsing.taken_away import Removal
from blockstab.rgbd.cloud import Cloud
from blockstab.rgbd.frame import Frame
from blockstab.scene.completion import Verdict
from blockstab.scene.types import Scene
from blockstab.stability.hidden_support import HiddenSupport


@dataclass(frozen=True)
class Parsed:
    """One image, understood. "Index" is a place among the N segments of `scene`, "id" a value of `label`.

    Args:
        name: the scene's name.
        frame: the image.
        cloud: its points in the world frame (+y up, origin at the camera, metres).
        label: (H, W) int64 output ids; 0 = no segment.
        scene: the N segments and what they mean.
        ids: N output ids, parallel to the segments of `scene`; 1 and up, since 0 stands for the ground plane.
        unary: (N,) potential of each segment; lower is better.
        pairwise: (M,) potential of each pair that shares a border: the pairs of `scene.pairs` with
            `neighbours` true, in their order; NaN where one of them is background, which is not judged.
        badness: (N,) probability that a segment is wrong.
        seen: N boxes, as far as they were seen; those of `scene` are completed.
        verdict: N, why each segment stands or does not.
        unseen: by segment index, what carries it and was not seen.
        removal: what falls without each segment, why, and an order in which nothing does.
        judge: who said so, by the name of its class.
        energy: of the segmentation (Eq. 2).
        trace: the energy of the best that the search kept after each step, the first guess first.
        seconds: by stage, time spent; the stages do not overlap.
        potentials_name: where the potentials came from.
        potentials_sha256: 64 hexadecimal digits of their file.
        seed: of every random choice.

    Raises:
        ValueError: where the parts speak of different numbers of segments, pairs or pixels.
    """

    name: str
    frame: Frame
    cloud: Cloud
    label: Tensor
    scene: Scene
    ids: tuple[int, ...]
    unary: Tensor
    pairwise: Tensor
    badness: Tensor
    seen: Boxes
    verdict: tuple[Verdict, ...]
    unseen: Mapping[int, HiddenSupport]
    removal: Removal
    judge: str
    energy: float
    trace: tuple[float, ...]
    seconds: dict[str, float]
    potentials_name: str
    potentials_sha256: str
    seed: int

    def __post_init__(self) -> None:
        n, bordering = len(self.scene), int(self.scene.pairs.neighbours.sum())
        pixels = tuple(self.frame.depth.shape)
        for name, got, needed in (
            ("ids", (len(self.ids),), (n,)),
            ("unary", tuple(self.unary.shape), (n,)),
            ("badness", tuple(self.badness.shape), (n,)),
            ("seen", (len(self.seen),), (n,)),
            ("verdict", (len(self.verdict),), (n,)),
            ("pairwise", tuple(self.pairwise.shape), (bordering,)),
            ("label", tuple(self.label.shape), pixels),
        ):
            if got != needed:
                raise ValueError(
                    f"{self.name}: {name} must have shape {needed} to fit its scene, but has {got}."
                )
        if len(set(self.ids)) != n or min(self.ids, default=1) < 1:
            raise ValueError(
                f"{self.name}: output ids must be distinct and at least 1 (0 is the ground plane), "
                f"but are {self.ids}."
            )
