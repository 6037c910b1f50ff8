"""Whole parses are timed by the stages that they tell themselves, in older versions and in this one."""

from __future__ import annotations

from pathlib import Path

import pytest

from benchmarks.whole_images import HERE, named, run_of, summary
from blockstab.testing.photographs import BLOCKS, photograph
from tests.synthetic import write_folder


def test_a_parse_is_timed_and_weighed(tmp_path: Path) -> None:
    scene = write_folder(photograph(*BLOCKS[:2]).frame, tmp_path / "scene")
    found = summary(run_of(HERE, [scene], jobs=1))
    stages = found["stages"]
    parts = [stages[name][0] for name in ("before the search", "search", "removal")]
    assert min(parts) > 0
    assert stages["whole image"][0] == pytest.approx(sum(parts), abs=0.002)
    assert stages["whole image"][0] < found["wall_s"]
    assert found["peak_mib"] > 100


def test_of_several_images_the_median_and_the_greatest_count() -> None:
    seconds = [{"search": value} for value in (1.0, 5.0, 2.0)]
    run = {"seconds": seconds, "wall_s": 9.0, "cpu_s": 8.0, "peak_mib": 700}
    assert summary(run)["stages"] == {"search": [2.0, 5.0]}


def test_a_folder_is_named_by_what_stands_before_its_path(tmp_path: Path) -> None:
    assert named(f"osd={tmp_path}") == ("osd", tmp_path)
