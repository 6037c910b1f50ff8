"""Machine code is made ahead of its first use."""

from __future__ import annotations

from blockstab.scene.warming import warm_up


def test_warming_up_needs_nothing_but_the_package():
    warm_up()
