"""Census of a set of simulated scenes."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from blockstab.datasets.folder import read_truth
from blockstab.datasets.truth import ObjectTruth, Truth

CENSUS = "census.json"


@dataclass(frozen=True)
class Census:
    """Counts over a set.

    Args:
        scenes, objects: how many.
        fewest, most: objects in one scene.
        hardly_seen: objects too little seen to be scored.
        on_objects: share of the objects that stand on, or lean on, another object.
        felling: share of the scenes in which something falls when one thing is taken away.
        shapes: objects of each kind of shape.
        supports: support relations of each type.
    """

    scenes: int
    objects: int
    fewest: int
    most: int
    hardly_seen: int
    on_objects: float
    felling: float
    shapes: dict[str, int]
    supports: dict[str, int]

    def as_json(self) -> dict[str, Any]:
        """The counts, shares rounded to four places."""
        return {k: round(v, 4) if isinstance(v, float) else v for k, v in asdict(self).items()}

    def summary(self) -> str:
        """One line for people."""
        return (
            f"{self.objects} objects, {self.fewest} to {self.most} a scene, {self.hardly_seen} hardly seen; "
            f"{self.on_objects:.0%} on other objects; in {self.felling:.0%} of the scenes "
            "taking one thing away makes another fall"
        )


def census_of(folders: Sequence[Path]) -> Census:
    """Count what the truth of some scenes says."""
    truths = [read_truth(folder) for folder in folders]
    amounts = [len(truth.objects) for truth in truths]
    objects = [o for truth in truths for o in truth.objects]
    stacked = sum(_on_object(o, truth) for truth in truths for o in truth.objects)
    felling = sum(any(o.falls_if_removed for o in truth.objects) for truth in truths)
    return Census(
        scenes=len(truths),
        objects=len(objects),
        fewest=min(amounts),
        most=max(amounts),
        hardly_seen=sum(o.hardly_seen for o in objects),
        on_objects=stacked / len(objects),
        felling=felling / len(truths),
        shapes=_counted(o.kind or "" for o in objects),
        supports=_counted(word for o in objects for word in o.support_types or ()),
    )


def _on_object(thing: ObjectTruth, truth: Truth) -> bool:
    return any(i not in truth.background_ids for i in thing.supported_by or ())


def _counted(words: Any) -> dict[str, int]:
    return dict(sorted(Counter(words).items()))
