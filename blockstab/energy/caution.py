"""Price of leaving the segmentation that a search starts from."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

from blockstab.scene.types import Scene
from blockstab.segments.segmentation import Segment, Segmentation


@dataclass(frozen=True)
class Caution:
    """Price of what a segmentation has and the start has not, as a share of all pixels.

    What a search finds good is good in part because it is misjudged, as the winner of an auction pays too much. So
    every object that the start does not have costs `caution` times its pixels: a search leaves its start only for
    what promises more than that. A thing that is turned into background is lost whole, while background that is taken
    for a thing costs the score nothing: pixels that were no background in the start must promise more, `turning`.
    What was background and still is costs nothing, however it is divided.

    Args:
        start: the segmentation that is left with caution, of which is told what is background.
        pixel_count: of each atom.
        caution, turning: shares of pixels.
    """

    start: Segmentation
    pixel_count: Sequence[int]
    caution: float
    turning: float

    def __call__(self, scene: Scene) -> float:
        """The price of a scene."""
        known, price, total = self.start.background, 0.0, 0
        for segment, pixels, background in zip(
            scene.segmentation.segments, scene.pixel_count.tolist(), scene.background.tolist(), strict=True
        ):
            total += pixels
            if known.get(segment) == background:
                continue
            price += self.turning * self._newly(segment) if background else self.caution * pixels
        return price / max(total, 1)

    def _newly(self, segment: Segment) -> int:
        """The pixels of a segment that were no background in the start."""
        if segment not in self._turned:
            self._turned[segment] = sum(self.pixel_count[atom] for atom in segment - self._before)
        return self._turned[segment]

    @cached_property
    def _before(self) -> Segment:
        """The atoms of the start's background."""
        return Segment().union(*(s for s, background in self.start.told if background))

    @cached_property
    def _turned(self) -> dict[Segment, int]:
        return {}
