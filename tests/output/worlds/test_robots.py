"""What stands, stands in the simulator too; what falls, falls; and names, sizes and masses are right."""

from __future__ import annotations

from xml.etree import ElementTree

import numpy as np
import pytest

from blockstab.output.worlds.robots import DENSITY, mjcf, urdf
from blockstab.testing import worlds
from blockstab.testing.worlds import Block
from tests.output.worlds.arrangements import arranged


def after(blocks: tuple[Block, ...], seconds: float) -> tuple[np.ndarray, np.ndarray]:
    """Places of the boxes before and after so long, in MuJoCo."""
    mujoco = pytest.importorskip("mujoco", reason="the extra `sim` is not installed")
    model = mujoco.MjModel.from_xml_string(mjcf(arranged(*blocks, lifted=0.7), "world"))
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    before = data.xpos[1:].copy()
    mujoco.mj_step(model, data, round(seconds / model.opt.timestep))
    mujoco.mj_kinematics(model, data)
    return before, data.xpos[1:].copy()


OFF = (Block(0, 0.002, 0.2, 0.1), Block(0, 0.099, 0.2, 0.1))
WITH_A_WALL = (Block(0, 0, 0.2, 0.1), Block(0.3, 0, 0.2, 1.0, fixed=True))


@pytest.mark.parametrize("blocks", [worlds.STACK, worlds.BRIDGE, worlds.COUNTERWEIGHT, OFF, WITH_A_WALL])
def test_what_stands_stands_for_two_seconds(blocks):
    before, later = after(blocks, 2.0)
    assert float(np.abs(later - before).max()) < 0.002


def test_what_falls_falls():
    before, later = after(worlds.overhang(0.03), 2.0)
    assert float(np.abs(later - before).max()) > 0.02


def test_boxes_that_overlap_sideways_are_not_thrown_apart():
    before, later = after((Block(0, 0, 0.1, 0.1), Block(0.09, 0, 0.1, 0.1)), 2.0)
    assert float(np.abs(later - before).max()) < 0.002


def test_links_have_the_names_places_and_masses_of_boxes():
    root = ElementTree.fromstring(
        urdf(arranged(Block(0.5, 0, 0.2, 0.1, d=0.3), Block(2, 0, 1, 1, fixed=True)), "w")
    )
    assert [link.get("name") for link in root.findall("link")] == ["world", "block_0", "block_1"]
    assert [joint.get("type") for joint in root.findall("joint")] == ["floating", "fixed"]
    link = root.findall("link")[1]
    assert float(link.find("inertial/mass").get("value")) == pytest.approx(DENSITY * 0.2 * 0.1 * 0.3)
    size = [float(part) for part in link.find("collision/geometry/box").get("size").split()]
    assert sorted(size) == pytest.approx([0.1, 0.2, 0.3])
    place = [float(part) for part in root.find("joint/origin").get("xyz").split()]
    assert place == pytest.approx([0.5, 0.0, 0.05])
