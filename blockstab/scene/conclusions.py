"""Conclusions on a scene after its search: what stands, and what must be there unseen for it to stand."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Protocol

from blockstab.boxes.box import Boxes
from blockstab.boxes.separation import separation
from blockstab.scene.builder import SceneBuilder
from blockstab.scene.completion import Verdict, completed
from blockstab.scene.types import Scene
from blockstab.stability.hidden_support import HiddenSupport

_SURFACE_M = 0.005  # further behind a surface that was seen than this, a thing was hidden by it


@dataclass(frozen=True)
class Conclusion:
    """Conclusion on a scene of N segments.

    Args:
        scene: with its boxes completed, and the relations and verdicts that then hold.
        seen: N boxes, as far as they were seen.
        verdict: N, why each stands or does not.
        unseen: by segment index, what carries it and was not seen.
    """

    scene: Scene
    seen: Boxes
    verdict: tuple[Verdict, ...]
    unseen: Mapping[int, HiddenSupport] = field(default_factory=dict)


class Concluding(Protocol):
    """Concludes what stands; the plug-in point of `Parser.concluding`."""

    def __call__(self, scene: Scene, build: SceneBuilder, /) -> Conclusion:
        """Conclude on a scene that `build` has made."""


@dataclass(frozen=True)
class AsSeen:
    """Concludes nothing: boxes and verdicts are those of the search."""

    def __call__(self, scene: Scene, build: SceneBuilder) -> Conclusion:
        """The scene as it is."""
        states = zip(scene.background.tolist(), scene.balance.stable.tolist(), strict=True)
        verdict = tuple(
            Verdict.BACKGROUND if background else Verdict.STABLE if stable else Verdict.UNSTABLE
            for background, stable in states
        )
        return Conclusion(scene, scene.boxes, verdict)


@dataclass(frozen=True)
class WhatStands:
    """Completes boxes where they were hidden, so that the scene stands (`completion.completed`)."""

    def __call__(self, scene: Scene, build: SceneBuilder) -> Conclusion:
        """The scene completed."""
        situation, surface = build.as_seen(scene), build.occlusion.without_gaps()
        found = completed(situation, lambda points: surface.hidden(points, _SURFACE_M))
        boxes, pairs = found.situation.boxes, scene.pairs
        apart = separation(boxes, pairs.first, pairs.second)
        whole = replace(
            scene,
            boxes=boxes,
            pairs=replace(pairs, gap=apart.gap, direction=apart.direction),
            candidates=found.candidates,
            supports=found.verdicts.supports,
            balance=found.verdicts.balance,
        )
        return Conclusion(whole, situation.boxes, found.verdict, found.unseen)
