"""Imports point one way, and importing is cheap."""

from __future__ import annotations

import ast
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
# A part may import those before it.
ORDER = (
    *(
        "determinism",
        "executors",
        "geometry",
        "rgbd",
        "segments",
        "boundaries",
        "observation",
        "boxes",
        "stability",
        "scene",
    ),
    *("features", "proposals", "energy", "search", "parsing", "output"),
    *("datasets", "simulation", "evaluation", "testing", "commands", "cli"),
)
LEARNED = ("potentials", "shipped", "gathering", "boundary", "stages", "configured", "entry", "programs")
HEAVY = ("open3d", "pytorch_lightning", "mujoco", "plotly", "sklearn", "hydra", "numba", "ray")
SOURCES = sorted((ROOT / "blockstab").rglob("*.py"))
OF_MODELS = sorted((ROOT / "models").rglob("*.py"))


def part_of(file: Path) -> str:
    return file.relative_to(ROOT).parts[1].removesuffix(".py")


def imported(file: Path) -> Iterator[list[str]]:
    """What a file imports, inside functions too, each name split at its dots."""
    for node in ast.walk(ast.parse(file.read_text())):
        if isinstance(node, ast.Import):
            yield from (alias.name.split(".") for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{file} must import by full paths"
            yield from (f"{node.module}.{alias.name}".split(".") for alias in node.names)


def test_every_part_has_a_place_in_the_order():
    assert {part_of(file) for file in SOURCES} == {"__init__", *ORDER}


@pytest.mark.parametrize("file", SOURCES, ids=lambda file: str(file.relative_to(ROOT)))
def test_imports_point_one_way(file):
    own = part_of(file)
    for package, *inner in imported(file):
        assert package not in ("tests", "train", "evaluate")
        assert package != "models" or own == "commands", "only commands may load potentials"
        if package == "blockstab" and inner[0] in ORDER:
            assert inner[0] == own or ORDER.index(inner[0]) < ORDER.index(own), f"{own} imports {inner[0]}"


def test_every_part_of_what_is_learned_has_a_place_in_the_order():
    assert {part_of(file) for file in OF_MODELS} == {"__init__", *LEARNED}


@pytest.mark.parametrize("file", OF_MODELS, ids=lambda file: str(file.relative_to(ROOT)))
def test_imports_inside_of_models_point_one_way(file):
    own = part_of(file)
    for package, *inner in imported(file):
        assert package not in ("tests", "train", "evaluate")
        assert [package, *inner][:2] != ["blockstab", "cli"]
        if package == "models":
            assert inner[0] == own or LEARNED.index(inner[0]) < LEARNED.index(own), (
                f"{own} imports {inner[0]}"
            )


def test_who_asks_for_help_does_not_wait_for_torch():
    program = "import blockstab.cli, sys; print('torch' in sys.modules, 'numpy' in sys.modules)"
    found = subprocess.run(
        [sys.executable, "-c", program], cwd=ROOT, capture_output=True, text=True, check=True
    )
    assert found.stdout.split() == ["False", "False"]


@pytest.mark.parametrize(
    "module", ["blockstab", "blockstab.cli", "blockstab.parsing.parser, models.potentials.checkpoint"]
)
def test_importing_loads_nothing_heavy(module):
    program = f"import {module}, sys; print([name for name in {HEAVY} if name in sys.modules])"
    found = subprocess.run(
        [sys.executable, "-c", program], cwd=ROOT, capture_output=True, text=True, check=True
    )
    assert found.stdout.strip() == "[]"
