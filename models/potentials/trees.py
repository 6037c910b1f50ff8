"""Boosted trees as LightGBM's text, looked through before LightGBM reads it: what it cannot read ends the process."""

from __future__ import annotations

import re
from functools import lru_cache
from typing import Any

_NUMBER = r"-?(?:\d+(?:\.\d+)?(?:e[+-]?\d+)?|inf|nan)"
_NUMBERS = re.compile(rf"{_NUMBER}(?: {_NUMBER})*")
_OBJECTIVES = ("cross_entropy", "binary sigmoid:1")
_OF_SPLITS = ("split_feature", "split_gain", "threshold", "decision_type", "left_child", "right_child")
_OF_SPLITS_ALSO = ("internal_value", "internal_weight", "internal_count")
_OF_LEAVES = ("leaf_value", "leaf_weight", "leaf_count")
_DECISIONS = frozenset(range(0, 16, 2))  # odd ones are of categories


# Reading the text takes longer than judging an image.
@lru_cache(maxsize=32)
def booster(text: str, features: int) -> Any:
    """LightGBM's model of a text, read once.

    Args:
        features: how many there are of each row.

    Raises:
        ValueError: in one line, if it is none.
    """
    from lightgbm import Booster
    from lightgbm.basic import LightGBMError

    try:
        return Booster(model_str=checked_trees(text, features))
    except (LightGBMError, ValueError) as error:
        raise ValueError(f"the trees cannot be read: {' '.join(str(error).split()):.200}") from None


def checked_trees(text: str, features: int) -> str:
    """The text with all left out that predictions do not need: such as training's parameters.

    Raises:
        ValueError: unless it holds trees over that many features, whole and without loops.
    """
    header, found, body = text.partition("\n\nTree=0\n")
    if not found or not text.isascii():
        raise ValueError("there is no first tree")
    said = dict(line.partition("=")[::2] for line in header.splitlines())
    objective, sizes = said.get("objective", ""), said.get("tree_sizes", "")
    if said.get("max_feature_idx") != str(features - 1):
        raise ValueError(
            f"their last feature must be {features - 1}, but is {said.get('max_feature_idx')!r:.40}"
        )
    if objective not in _OBJECTIVES or not re.fullmatch(r"\d{1,9}(?: \d{1,9})*", sizes):
        raise ValueError(f"their objective, {objective!r:.40}, or their sizes, {sizes!r:.40}, make no sense")
    body, place = f"Tree=0\n{body}", 0
    for number, size in enumerate(map(int, sizes.split(" "))):
        _check_tree(body[place : place + size], number, features)
        place += size
    if not body[place:].lstrip("\n").startswith("end of trees\n"):
        raise ValueError("there is more than the trees that were announced")
    head = {
        "version": "v4",
        "num_class": "1",
        "num_tree_per_iteration": "1",
        "label_index": "0",
        "max_feature_idx": str(features - 1),
        "objective": objective,
        "feature_names": " ".join(f"Column_{k}" for k in range(features)),
        "feature_infos": " ".join(["none"] * features),
        "tree_sizes": sizes,
    }
    lines = "\n".join(["tree", *(f"{name}={value}" for name, value in head.items())])
    return f"{lines}\n\n{body[:place]}\n\nend of trees\n"


def _check_tree(text: str, number: int, features: int) -> None:
    lines = text.rstrip("\n").split("\n")
    said = dict(line.partition("=")[::2] for line in lines[1:])
    if lines[0] != f"Tree={number}" or len(said) != len(lines) - 1 or not text.endswith("\n\n"):
        raise ValueError(f"tree {number} is not where it should be")
    values = {name: line.split(" ") for name, line in said.items() if _NUMBERS.fullmatch(line)}
    empty = {name for name, line in said.items() if line == ""}
    leaves = _whole(values.get("num_leaves", []), 1, 10**6, number)
    if len(leaves) != 1 or values.get("num_cat") != ["0"] or values.get("is_linear") != ["0"]:
        raise ValueError(f"tree {number} is no plain regression tree")
    splits = leaves[0] - 1
    sizes = dict.fromkeys((*_OF_SPLITS, *_OF_SPLITS_ALSO), splits) | dict.fromkeys(_OF_LEAVES, splits + 1)
    sizes |= dict.fromkeys(("num_leaves", "num_cat", "is_linear", "shrinkage"), 1)
    short = {"leaf_weight", "leaf_count"} if not splits else set()  # a single leaf has none of these
    for name, size in sizes.items():
        got = 0 if name in empty else len(values.get(name, []))
        if got != size and name not in short:
            raise ValueError(f"tree {number} must have {size} of {name}, but has {got}")
    if re.search("[a-df-z]", said["leaf_value"]):
        raise ValueError(f"tree {number} has leaves that are no numbers")
    if said.keys() - sizes.keys() or said.keys() - values.keys() - empty:
        raise ValueError(f"tree {number} holds what no tree has")
    if not splits:
        return
    _whole(values["split_feature"], 0, features - 1, number)
    if not set(_whole(values["decision_type"], 0, 15, number)) <= _DECISIONS:
        raise ValueError(f"tree {number} decides by categories")
    for side in ("left_child", "right_child"):
        for parent, child in enumerate(_whole(values[side], -splits - 1, splits - 1, number)):
            if 0 <= child <= parent:
                raise ValueError(f"tree {number} leads back from node {parent} to node {child}")


def _whole(words: list[str], low: int, high: int, number: int) -> list[int]:
    """The words as whole numbers between two others."""
    if not all(re.fullmatch(r"-?\d{1,9}", word) and low <= int(word) <= high for word in words):
        raise ValueError(f"tree {number} has numbers out of their range")
    return [int(word) for word in words]
