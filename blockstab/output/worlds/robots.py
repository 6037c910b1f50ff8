"""Worlds for simulators and planners: MJCF, which MuJoCo opens, and URDF."""

from __future__ import annotations

from xml.etree import ElementTree
from xml.etree.ElementTree import Element, SubElement

from torch import Tensor

from blockstab.output.coloring import WORLD_COLORS
from blockstab.output.worlds.poses import fixed_angles, numbers, on_z_plane, quaternion_of
from blockstab.output.worlds.settled import overlapping, settled
from blockstab.stability.arrangement import Arrangement
from blockstab.stability.contacts import FRICTION

DENSITY = 500.0  # kilograms a cubic metre, of every box: no image tells
_DEEP_M = 0.001  # boxes that overlap more are let through each other


def mjcf(asked: Arrangement, name: str) -> str:
    """A world of MuJoCo: boxes that are free to move on a plane, background that is not; metres, z up.

    Objects are set down on what carries them (`settled`). Two boxes that overlap still, sideways, are told not to
    touch, for they would be thrown apart.
    """
    asked = settled(asked)
    boxes = on_z_plane(asked)
    root = Element("mujoco", model=name)
    SubElement(root, "option", timestep="0.002", cone="elliptic", impratio="10")
    body = SubElement(root, "worldbody")
    surface = {"friction": numbers((FRICTION, 0.005, 0.002)), "solref": "0.005 1"}
    SubElement(body, "light", pos="0 0 3", dir="0 0 -1")
    SubElement(
        body, "geom", {"name": "ground", "type": "plane", "size": "0 0 1", "rgba": "0.8 0.8 0.8 1", **surface}
    )
    for i, own in enumerate(asked.ids):
        place = {"pos": numbers(boxes.center[i]), "quat": numbers(quaternion_of(boxes.rotation[i]))}
        thing = SubElement(body, "body", {"name": own, **place})
        if bool(asked.movable[i]):
            SubElement(thing, "freejoint")
        shape = {"type": "box", "size": numbers(boxes.half_extent[i]), "density": f"{DENSITY:g}"}
        SubElement(thing, "geom", {"rgba": _color(i), **shape, **surface})
    contact = SubElement(root, "contact")
    for a, b in overlapping(asked, _DEEP_M):
        SubElement(contact, "exclude", body1=asked.ids[a], body2=asked.ids[b])
    return _text(root)


def urdf(asked: Arrangement, name: str) -> str:
    """A robot description whose links are the boxes, floating in `world`, or fixed to it; metres, kilograms, z up."""
    asked = settled(asked)
    boxes = on_z_plane(asked)
    root = Element("robot", name=name)
    SubElement(root, "link", name="world")
    for i, own in enumerate(asked.ids):
        size = 2 * boxes.half_extent[i]
        link = SubElement(root, "link", name=own)
        inertial = SubElement(link, "inertial")
        mass = DENSITY * float(size.prod())
        SubElement(inertial, "mass", value=f"{mass:.9g}")
        SubElement(inertial, "inertia", _inertia(size, mass))
        for part in ("visual", "collision"):
            shown = SubElement(link, part)
            SubElement(SubElement(shown, "geometry"), "box", size=numbers(size))
            if part == "visual":
                material = SubElement(shown, "material", name=f"color_{own}")
                SubElement(material, "color", rgba=_color(i))
        joint = SubElement(
            root, "joint", name=f"to_{own}", type="floating" if bool(asked.movable[i]) else "fixed"
        )
        SubElement(joint, "parent", link="world")
        SubElement(joint, "child", link=own)
        turned = numbers(fixed_angles(boxes.rotation[i]))
        SubElement(joint, "origin", xyz=numbers(boxes.center[i]), rpy=turned)
    return _text(root)


def _inertia(size: Tensor, mass: float) -> dict[str, str]:
    """Of a box about its centre, kilograms times square metres."""
    x, y, z = (size**2).tolist()
    moments = {"ixx": y + z, "iyy": x + z, "izz": x + y}
    return {
        **{key: f"{mass * value / 12:.9g}" for key, value in moments.items()},
        **dict.fromkeys(("ixy", "ixz", "iyz"), "0"),
    }


def _color(i: int) -> str:
    return numbers((*(part / 255 for part in WORLD_COLORS[i % len(WORLD_COLORS)]), 1.0))


def _text(root: Element) -> str:
    ElementTree.indent(root)
    return ElementTree.tostring(root, encoding="unicode") + "\n"
