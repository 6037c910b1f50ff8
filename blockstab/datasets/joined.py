"""Several sets of scenes as one."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from blockstab.datasets.sets import SceneSet
from blockstab.datasets.truth import Truth
from blockstab.rgbd.frame import Frame

_BETWEEN = "-"  # the name of a set and that of its scene


@dataclass(frozen=True)
class JoinedScenes:
    """The scenes of several sets, one set after the other.

    Args:
        sets: by a short name each, which comes before the names of its scenes.

    Raises:
        ValueError: if there is no set, or a short name holds what parts it from the names of scenes.
    """

    sets: Mapping[str, SceneSet]

    def __post_init__(self) -> None:
        wrong = [name for name in self.sets if not name or _BETWEEN in name]
        if wrong or not self.sets:
            raise ValueError(
                f"Sets are joined by short names without {_BETWEEN!r}, one at least, but they are "
                f"{list(self.sets)!r:.120}; rename them."
            )

    @property
    def name(self) -> str:
        """The names of all sets."""
        return "+".join(data.name for data in self.sets.values())

    def scenes(self) -> list[str]:
        """The names of the scenes, in order."""
        return [f"{key}{_BETWEEN}{scene}" for key, data in self.sets.items() for scene in data.scenes()]

    def read(self, scene: str) -> tuple[Frame, Truth]:
        """One scene, under the name that it has here."""
        data, own = self._of(scene)
        frame, truth = data.read(own)
        return replace(frame, name=scene), truth

    def stamp(self, scene: str) -> str:
        """That of the set that the scene is from."""
        data, own = self._of(scene)
        return f"{type(data).__name__} {data.stamp(own)}"

    def official(self) -> Mapping[str, Sequence[str]]:
        """None: sets part in ways of their own."""
        return {}

    def _of(self, scene: str) -> tuple[SceneSet, str]:
        key, _, own = scene.partition(_BETWEEN)
        return self.sets[key], own
