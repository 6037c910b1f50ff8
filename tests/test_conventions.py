"""What holds for every file of the packages."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
DRAWS = {"rand", "randn", "randint", "randperm", "multinomial", "bernoulli", "normal", "poisson"}
GLOBAL_SEEDS = {"torch.manual_seed", "torch.seed", "np.random.seed", "random.seed", "pl.seed_everything"}


def trees(*packages: str) -> Iterator[tuple[str, ast.Module]]:
    """All source files by their paths, parsed."""
    for file in sorted(file for package in packages for file in (ROOT / package).rglob("*.py")):
        yield str(file.relative_to(ROOT)), ast.parse(file.read_text())


def public(body: list[ast.stmt]) -> Iterator[ast.FunctionDef | ast.ClassDef]:
    """Public functions, classes and methods; not those that a Protocol only names, with `...` for a body."""
    for node in body:
        if isinstance(node, ast.FunctionDef | ast.ClassDef) and not node.name.startswith("_"):
            if ast.unparse(node.body[0]) != "...":
                yield node
            if isinstance(node, ast.ClassDef):
                yield from public(node.body)


def test_every_public_name_has_a_docstring():
    silent = [path for path, tree in trees("blockstab", "models") if not ast.get_docstring(tree)]
    for path, tree in trees("blockstab"):
        silent += [f"{path}: {node.name}" for node in public(tree.body) if not ast.get_docstring(node)]
    assert silent == []


@pytest.mark.parametrize("package", ["blockstab", "models"])
def test_convention_randomness_is_a_generator_never_global_state(package):
    wrong = []
    for path, tree in trees(package):
        for call in (node for node in ast.walk(tree) if isinstance(node, ast.Call)):
            name, keywords = ast.unparse(call.func), {keyword.arg for keyword in call.keywords}
            draws = name.startswith("torch.") and name.removeprefix("torch.") in DRAWS
            if name in GLOBAL_SEEDS or (draws and "generator" not in keywords):
                wrong.append(f"{path}:{call.lineno}: {name}")
    assert wrong == []
