"""docs/conventions.md names the tests that hold the conventions."""

from __future__ import annotations

import ast
import re

from tests.docs.pages import DOCS, ROOT

PAGE = (DOCS / "conventions.md").read_text()
SYMBOLS = {"phi", "psi", "theta", "theta_sep", "d_min", "p_c", "s_1", "s_2", "w_s", "w_p"}


def functions(source: str) -> set[str]:
    return set(re.findall(r"^def (test_\w+)", source, re.MULTILINE))


def test_every_test_named_on_the_page_exists():
    named = re.findall(r"`(tests/\S+?\.py)::(test_\w+)`", PAGE)
    assert named
    for file, name in named:
        assert name in functions((ROOT / file).read_text()), f"{file} has no {name}"


def test_every_test_of_a_convention_is_on_the_page():
    for file in (ROOT / "tests").rglob("test_*.py"):
        for name in functions(file.read_text()):
            if name.startswith("test_convention_"):
                assert f"`{file.relative_to(ROOT)}::{name}`" in PAGE


def test_every_convention_has_a_test():
    rows = [line for line in PAGE.split("|---|---|---|\n")[1].split("\n\n")[0].splitlines() if line]
    assert all("::test_" in row for row in rows)


def test_convention_arguments_have_words_not_symbols():
    for package in ("blockstab", "models"):
        for file in (ROOT / package).rglob("*.py"):
            for node in ast.walk(ast.parse(file.read_text())):
                if isinstance(node, ast.arg):
                    assert node.arg.lower() not in SYMBOLS, f"{file}:{node.lineno}"
