"""Ratios of times to those of a peer, and what counts as a regression."""

from __future__ import annotations

import pytest

from benchmarks.ratios import SLACK, ratios_of, regressions


def run(**seconds: float) -> dict[str, list[dict[str, object]]]:
    return {
        "benchmarks": [
            {"group": "boxes", "name": name, "stats": {"min": least}} for name, least in seconds.items()
        ]
    }


def test_a_ratio_is_the_time_by_that_of_the_peer_in_the_same_group():
    found = ratios_of(run(test_ours=0.5, test_box_of_open3d=2.0, test_steps=4.0))
    assert found == {"boxes": {"test_ours": 0.25, "test_steps": 2.0}}


def test_a_peer_may_have_parameters():
    both = {"test_open3d[free]": 2.0, "test_ours[free]": 1.0}
    assert ratios_of(run(**both)) == {"boxes": {"test_ours[free]": 0.5}}


def test_a_group_without_a_peer_has_no_ratios():
    assert ratios_of(run(test_ours=0.5)) == {}


@pytest.mark.parametrize(("ratio", "amount"), [(0.1, 0), (0.5 * SLACK, 0), (0.5 * SLACK + 0.01, 1)])
def test_a_regression_is_a_ratio_worse_by_more_than_half(ratio, amount):
    worse = regressions({"boxes": {"test_ours": ratio, "test_new": 9.0}}, {"boxes": {"test_ours": 0.5}})
    assert len(worse) == amount
    assert all("test_ours" in line for line in worse)
