"""Another library reads the meshes back: names, places, sizes and volumes."""

from __future__ import annotations

import io

import numpy as np
import pytest

from blockstab.output.worlds.meshes import glb, ply
from blockstab.testing import worlds
from blockstab.testing.worlds import Block
from tests.output.worlds.arrangements import arranged

trimesh = pytest.importorskip("trimesh", reason="trimesh reads the meshes back")
BLOCKS = (*worlds.STACK, Block(0.5, 0, 0.1, 0.3, z=0.4, tilt_deg=20.0))


def read(content: bytes, kind: str):
    return trimesh.load(io.BytesIO(content), file_type=kind, process=False)


def test_a_glb_has_a_node_for_each_box_where_it_is():
    asked = arranged(*BLOCKS, lifted=-0.4)
    scene = read(glb(asked, "pile"), "glb")
    assert {"block_0", "block_1", "block_2"} <= set(scene.graph.nodes)
    for k, name in enumerate(asked.ids):
        transform, geometry = scene.graph[name]
        mesh = scene.geometry[geometry].copy().apply_transform(transform)
        corners = asked.boxes.corners()[k].numpy() + np.array([0.0, 0.4, 0.0])
        assert mesh.bounds == pytest.approx(np.stack([corners.min(axis=0), corners.max(axis=0)]), abs=1e-6)
        assert mesh.volume == pytest.approx(float(asked.boxes.volume()[k]), rel=1e-5)


def test_faces_of_a_ply_look_outward():
    asked = arranged(*BLOCKS)
    mesh = read(ply(asked).encode(), "ply")
    mesh.merge_vertices()
    parts = mesh.split()
    assert sorted(part.volume for part in parts) == pytest.approx(
        sorted(asked.boxes.volume().tolist()), rel=1e-6
    )
    assert all(part.is_watertight for part in parts)
