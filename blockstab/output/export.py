"""The files of one parse: labels.png, report.html, scene.json."""

from __future__ import annotations

import json
import math
import os
from importlib.resources import files
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np
import torch
from PIL import Image

from blockstab.boxes.box import Boxes
from blockstab.output.report import report_html
from blockstab.parsing.parsed import Parsed
from blockstab.stability.support import GROUND, SupportType

SCHEMA_VERSION = 2
MAX_ID = 65535  # labels.png holds 16 bits a pixel

Record = dict[str, Any]


def scene_schema() -> Record:
    """The JSON schema (draft 2020-12) that every `scene_record` follows."""
    schema: Record = json.loads(
        files("blockstab.output").joinpath("scene.schema.json").read_text(encoding="utf-8")
    )
    return schema


def scene_record(parsed: Parsed) -> Record:
    """Content of scene.json, as plain Python values: metres, boxes and directions in the camera frame.

    Raises:
        ValueError: naming the first number that is not finite.
    """
    scene, ground = parsed.scene, parsed.scene.ground
    output_id = {GROUND: 0, **dict(enumerate(parsed.ids))}
    supports = scene.supports
    record = {
        "schema": SCHEMA_VERSION,
        "up_camera": ground.up_camera.tolist(),
        "up_confidence": ground.confidence,
        "world_from_camera": ground.world_from_camera.tolist(),
        "ground_height_m": ground.height,
        "segments": _segments(parsed),
        "pairs": _pairs(parsed),
        "supports": [
            {"supporter": output_id[a], "supported": output_id[b], "type": SupportType(t).name.lower()}
            for a, b, t in zip(
                supports.supporter.tolist(), supports.supported.tolist(), supports.type.tolist(), strict=True
            )
        ],
        "falls_if_removed": {
            str(output_id[i]): sorted(output_id[j] for j in fallen)
            for i, fallen in sorted(parsed.removal.falls.items())
        },
        "falls_because": _reasons(parsed),
        "removal_order": None
        if parsed.removal.order is None
        else [output_id[i] for i in parsed.removal.order],
        "judge": parsed.judge,
        "energy": parsed.energy,
        "energy_trace": list(parsed.trace),
        "seconds": dict(parsed.seconds),
        "potentials": {"name": parsed.potentials_name, "sha256": parsed.potentials_sha256},
        "seed": parsed.seed,
    }
    _require_finite(record, parsed.name)
    return record


def write_parsed(parsed: Parsed, folder: Path, report: bool = True) -> None:
    """Write labels.png, report.html (if asked for) and scene.json into `folder`, which is made where it is missing.

    Each file appears whole or not at all. An older scene.json goes first and the new one comes last, so that
    a folder with one holds a finished scene.

    Raises:
        ValueError: where an output id does not fit the 16 bits of labels.png, or a number is not finite.
    """
    label, page = _label_png(parsed), report_html(parsed) if report else None
    record = json.dumps(scene_record(parsed), indent=1, allow_nan=False) + "\n"
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "scene.json").unlink(missing_ok=True)
    write_whole(folder / "labels.png", label)
    if page is not None:
        write_whole(folder / "report.html", page.encode())
    write_whole(folder / "scene.json", record.encode())


def write_whole(path: Path, content: bytes) -> None:
    """Write under a temporary name beside `path`, then rename: a killed run leaves a whole file or none."""
    temporary = path.with_name(f".{path.name}.{os.getpid()}.tmp")
    try:
        temporary.write_bytes(content)
        temporary.replace(path)
    finally:
        temporary.unlink(missing_ok=True)


def _segments(parsed: Parsed) -> list[Record]:
    scene = parsed.scene
    boxes, seen = (some.rotated(scene.ground.world_from_camera.T) for some in (scene.boxes, parsed.seen))
    return [
        {
            "id": parsed.ids[i],
            "background": bool(scene.background[i]),
            "pixels": int(scene.pixel_count[i]),
            "box": _box(boxes, i),
            "seen_box": _box(seen, i),
            "fit": {
                "mean_m": float(scene.fit_mean[i]),
                "variance_m2": float(scene.fit_variance[i]),
                "visible_share": float(scene.visible_share[i]),
            },
            "stable": bool(scene.balance.stable[i]),
            "verdict": str(parsed.verdict[i]),
            "unseen_support": _unseen(parsed, i),
            "margin_m": _or_null(float(scene.balance.margin[i])) if not scene.background[i] else None,
            "potential": float(parsed.unary[i]),
            "badness": float(parsed.badness[i]),
        }
        for i in range(len(scene))
    ]


def _box(boxes: Boxes, i: int) -> Record:
    return {
        "center": boxes.center[i].tolist(),
        "rotation": boxes.rotation[i].tolist(),
        "half_extent": boxes.half_extent[i].tolist(),
    }


def _unseen(parsed: Parsed, i: int) -> Record | None:
    """What carries a segment unseen: where it can touch it, in the camera frame, and how tall it can be."""
    if i not in parsed.unseen:
        return None
    found = parsed.unseen[i]
    height = found.area.new_full((len(found.area), 1), found.top)
    corners = torch.cat([found.area[:, :1], height, found.area[:, 1:]], dim=1)
    return {
        "area": (corners @ parsed.scene.ground.world_from_camera).tolist(),
        "height_m": found.top - found.bottom,
    }


def _reasons(parsed: Parsed) -> dict[str, dict[str, str]]:
    """By segment id, by the id of what falls without it: why."""
    found: dict[str, dict[str, str]] = {}
    for (taken, fallen), reason in sorted(parsed.removal.reasons.items()):
        found.setdefault(str(parsed.ids[taken]), {})[str(parsed.ids[fallen])] = str(reason)
    return found


def _or_null(number: float) -> float | None:
    return number if math.isfinite(number) else None


def _pairs(parsed: Parsed) -> list[Record]:
    pairs = parsed.scene.pairs
    potentials = iter(parsed.pairwise.tolist())
    directions = (pairs.direction @ parsed.scene.ground.world_from_camera).tolist()
    columns = (
        pairs.first.tolist(),
        pairs.second.tolist(),
        pairs.gap.tolist(),
        directions,
        pairs.neighbours.tolist(),
    )
    return [
        {
            "a": parsed.ids[a],
            "b": parsed.ids[b],
            "gap_m": gap,
            "direction_camera": direction,
            "neighbours": neighbours,
            "potential": _or_null(next(potentials)) if neighbours else None,
        }
        for a, b, gap, direction, neighbours in zip(*columns, strict=True)
    ]


def _label_png(parsed: Parsed) -> bytes:
    if max(parsed.ids, default=0) > MAX_ID:
        raise ValueError(
            f"{parsed.name}: labels.png holds ids up to {MAX_ID}, but the {len(parsed.ids)} segments reach "
            f"{max(parsed.ids)}; number them from 1, or propose fewer segments."
        )
    buffer = BytesIO()
    Image.fromarray(parsed.label.cpu().numpy().astype(np.uint16)).save(buffer, format="PNG")
    return buffer.getvalue()


def _require_finite(value: Any, where: str) -> None:
    if isinstance(value, dict):
        for key, part in value.items():
            _require_finite(part, f"{where}.{key}")
    elif isinstance(value, list):
        for i, part in enumerate(value):
            _require_finite(part, f"{where}[{i}]")
    elif isinstance(value, float) and not math.isfinite(value):
        raise ValueError(f"{where} must be a finite number, but is {value}; mend the stage that made it.")
