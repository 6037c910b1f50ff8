"""One file of results from those of several folds: python docs/pool.py out/fold*/results.json --out all.json."""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).parents[1]))

from blockstab.evaluation.scoring import Score
from blockstab.evaluation.scoring.rows import Scored, rows_of
from blockstab.output.export import write_whole

ALIKE = ("experiment", "seed", "versions")  # what all folds must have in common
OVER_OBJECTS = ("axis_error_deg", "support_accuracy", "support_below", "stable_share", "flat_found")


def pool(folds: Sequence[dict[str, Any]]) -> dict[str, Any]:
    """The results over the scenes of all folds, each of which must be scored in one of them.

    Raises:
        ValueError: the folds are not of one experiment, share a scene, or have a score that counts objects, of which
            the files do not tell how many an image has.
    """
    first = folds[0]
    if any(fold[key] != first[key] for fold in folds for key in ALIKE):
        raise ValueError(f"Folds must agree in {', '.join(ALIKE)}, but do not; pool those of one experiment.")
    rows = [_joined(same) for same in zip(*(fold["rows"] for fold in folds), strict=True)]
    data = {
        **first["data"],
        "part": "+".join(fold["data"]["part"] for fold in folds),
        "images": sum(fold["data"]["images"] for fold in folds),
        "left_out": sorted(scene for fold in folds for scene in fold["data"]["left_out"]),
    }
    seconds = round(sum(fold["seconds"] for fold in folds), 2)
    return {**first, "data": data, "rows": rows_of(rows, first["seed"]), "seconds": seconds}


def _joined(rows: Sequence[dict[str, Any]]) -> Scored:
    names = list(rows[0]["scores"])
    if any(row["method"] != rows[0]["method"] or list(row["scores"]) != names for row in rows):
        raise ValueError(
            "Folds must have the same methods and scores, but have not; pool those of one experiment."
        )
    if any(name in OVER_OBJECTS for name in names):
        raise ValueError(
            f"Scores over objects cannot be pooled ({', '.join(names)}); evaluate part=all instead."
        )
    per_image = {scene: scores for row in rows for scene, scores in row["per_image"].items()}
    if len(per_image) < sum(len(row["per_image"]) for row in rows):
        raise ValueError("Folds must have no scene in common, but have; pool the parts of one split.")
    scores = {
        scene: {name: Score(value, 1) for name, value in found.items()} for scene, found in per_image.items()
    }
    return Scored(rows[0]["method"], rows[0]["potential"], tuple(names), scores)


def main() -> int:
    """Pool files; 1 if they do not fit together."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("files", nargs="+", type=Path)
    parser.add_argument("--out", required=True, type=Path)
    asked = parser.parse_args()
    try:
        results = pool([json.loads(file.read_text()) for file in asked.files])
    except (ValueError, KeyError, OSError) as error:
        print(f"{asked.files[0]} and {len(asked.files) - 1} more: {error}", file=sys.stderr)
        return 1
    write_whole(asked.out, (json.dumps(results, indent=1) + "\n").encode())
    return 0


if __name__ == "__main__":
    sys.exit(main())
