"""Parts of a simulation by name."""

from __future__ import annotations

import pytest

from blockstab.simulation.layouts.blocks import arrange_blocks
from blockstab.simulation.layouts.presets import PRESETS, Preset, preset
from blockstab.simulation.naming import named
from blockstab.simulation.sensors import Ideal, sensor
from blockstab.simulation.simulated import Recipe

CROWD = Preset(arrange_blocks, 0.5, "table")


def test_our_parts_have_names():
    assert preset("blocks") is PRESETS["blocks"]
    assert named("sensor", "a", {"a": 3}) == 3


def test_a_value_of_ones_own_is_taken_and_a_class_of_ones_own_is_made():
    assert preset("tests.simulation.test_naming.CROWD") is CROWD
    assert sensor("blockstab.simulation.sensors.ideal.Ideal") == Ideal()


def test_scenes_of_a_preset_of_ones_own_have_names_that_are_fit_for_folders():
    assert Recipe("tests.simulation.test_naming.CROWD").scene(7) == "CROWD_0007"
    assert Recipe("blocks").scene(7) == "blocks_0007"


@pytest.mark.parametrize("name", ["cubes", "tests.simulation.test_naming.NONE", "nowhere.at.ALL", "", "."])
def test_what_is_not_there_is_refused_in_one_line_with_what_there_is(name):
    with pytest.raises(
        ValueError, match="choose from: blocks, objects, grocery, desk, room, or name"
    ) as caught:
        preset(name)
    assert "\n" not in str(caught.value)
