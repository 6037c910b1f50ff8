"""A set of scenes that has names and nothing else."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from blockstab.datasets.truth import Truth
from blockstab.rgbd.frame import Frame


@dataclass(frozen=True)
class Names:
    """Scenes of which those in `damaged` cannot be read."""

    names: tuple[str, ...]
    name: str = "names"
    damaged: tuple[str, ...] = ()
    parts: Mapping[str, Sequence[str]] = field(default_factory=dict)

    def scenes(self) -> list[str]:
        return list(self.names)

    def read(self, scene: str) -> tuple[Frame, Truth]:
        if scene in self.damaged:
            raise ValueError(f"{scene}/depth.png: must be\na whole image")
        return None, None  # type: ignore[return-value]

    def stamp(self, scene: str) -> str:
        return scene

    def official(self) -> Mapping[str, Sequence[str]]:
        return self.parts
