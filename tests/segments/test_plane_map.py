"""The planes of an image: every face of a block is one, and nothing round is."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import pytest
import torch
from torch import Tensor

from blockstab.boxes.box import Boxes
from blockstab.observation import given_ground, observe
from blockstab.rgbd.cloud import Cloud, cloud_from_frame
from blockstab.rgbd.frame import Camera, Frame, read_scene
from blockstab.rgbd.noise import KINECT
from blockstab.segments.plane_map import PlaneFinder, PlaneMap, _fitted_again, find_planes
from blockstab.testing.photographs import BLOCKS, NOISE, photograph
from tests.block_scene import STACK, TABLE_Y, Block, Picture, picture
from tests.segments.faces import Faces, faces_of
from tests.tolerance import EXACT

# Two walls stand on the table, and make it a room.
CORNER: tuple[Block, ...] = (((-2.0, 0, 1.6), (2.0, 2.0, 1.8)), ((-0.9, 0, 0.1), (-0.7, 2.0, 1.6)))


def boxes_of(blocks: tuple[Block, ...]) -> Boxes:
    """The blocks of a picture, in its world frame."""
    low = torch.tensor([[a[0], a[1] + TABLE_Y, -b[2]] for a, b in blocks], dtype=torch.float64)
    high = torch.tensor([[b[0], b[1] + TABLE_Y, -a[2]] for a, b in blocks], dtype=torch.float64)
    return Boxes(
        (low + high) / 2, torch.eye(3, dtype=torch.float64).expand(len(blocks), 3, 3), (high - low) / 2
    )


def faces_in(scene: Picture, blocks: tuple[Block, ...]) -> Faces:
    assert scene.frame.label is not None
    return faces_of(boxes_of(blocks), scene.frame.label, scene.cloud.points)


def assert_each_face_is_one_plane(
    found: PlaneMap, faces: Faces, least_px: int, share: float, degrees: float
) -> None:
    """Of each face that is large enough, such a share has one label, and its normal is as near to the true one."""
    label_of: list[int] = []
    for face, normal in enumerate(faces.normals, start=1):
        labels = found.label[faces.label == face]
        if len(labels) >= least_px:
            label_of.append(int(labels.mode().values))
            assert label_of[-1] > 0
            assert float((labels == label_of[-1]).double().mean()) > share
            assert angle_deg(found.planes[label_of[-1] - 1, :3], normal) < degrees
    assert len(label_of) >= 3
    assert len(set(label_of)) == len(label_of)


def angle_deg(one: Tensor, other: Tensor) -> float:
    return math.degrees(math.acos(min(1.0, float(one @ other))))


def cloud_of(depth: Tensor, focal: float) -> Cloud:
    """What a camera sees whose axis goes through the middle of the depth image."""
    rows, columns = depth.shape
    camera = Camera(focal, focal, (columns - 1) / 2, (rows - 1) / 2)
    return cloud_from_frame(Frame("depth", torch.zeros(rows, columns, 3, dtype=torch.uint8), depth, camera))


def ball(radius: float, distance: float, rows: int = 240, columns: int = 320, focal: float = 290.0) -> Tensor:
    """(H, W) depth of a ball straight ahead; 0 beside it."""
    v, u = torch.meshgrid(torch.arange(rows).double(), torch.arange(columns).double(), indexing="ij")
    x, y = (u - (columns - 1) / 2) / focal, (v - (rows - 1) / 2) / focal
    square = x * x + y * y + 1.0
    root = distance**2 - square * (distance**2 - radius**2)
    return torch.where(root > 0, (distance - root.clamp(min=0).sqrt()) / square, 0.0)


@pytest.mark.parametrize("pitch", [25.0, 40.0])
def test_floor_and_walls_of_a_room_are_a_plane_each(pitch: float) -> None:
    scene = picture(CORNER, pitch)
    found = find_planes(scene.cloud)
    assert len(found.planes) == 3
    assert_each_face_is_one_plane(found, faces_in(scene, CORNER), 250, share=0.98, degrees=0.05)


def test_every_face_of_blocks_on_a_table_is_a_plane() -> None:
    scene = picture(STACK)
    found = find_planes(scene.cloud)
    assert len(found.planes) == 5
    assert_each_face_is_one_plane(found, faces_in(scene, STACK), 250, share=0.98, degrees=0.1)


@pytest.mark.parametrize("noise", [NOISE, 3 * NOISE])
def test_noise_turns_no_face_by_a_degree(noise: float) -> None:
    photo = photograph(*BLOCKS, noise=noise)
    exact = observe(photograph(*BLOCKS, noise=0.0).frame, given_ground).cloud
    assert photo.frame.label is not None
    faces = faces_of(photo.boxes, photo.frame.label, exact.points)
    found = find_planes(observe(photo.frame, given_ground).cloud)
    # Two of the faces lie 1 cm behind each other: a plane across both would be 6 degrees off.
    assert_each_face_is_one_plane(found, faces, 500, share=0.95, degrees=1.0)


def test_planes_are_where_their_pixels_are_and_face_the_camera() -> None:
    scene = picture(STACK)
    found = find_planes(scene.cloud)
    normal, offset = found.planes[:, :3], found.planes[:, 3]
    assert torch.allclose(normal.norm(dim=1), torch.ones(len(normal), dtype=torch.float64), atol=EXACT)
    assert bool((offset > 0).all())  # the camera, at the origin, is in front of each
    on = found.label > 0
    distance = (normal[found.label[on] - 1] * scene.cloud.points[on]).sum(dim=1) + offset[found.label[on] - 1]
    assert float(distance.abs().max()) < 0.0075 * float(scene.cloud.depth.max())


def test_round_things_are_no_planes() -> None:
    assert not find_planes(cloud_of(ball(0.15, 1.0), 290.0)).label.any()
    scene = picture(())
    inside = ball(0.15, 0.9)
    depth = torch.where((inside > 0) & (inside < scene.frame.depth), inside, scene.frame.depth)
    on_ball = depth < scene.frame.depth
    label = find_planes(cloud_of(depth, 290.0)).label
    assert float((label[on_ball] > 0).double().mean()) < 0.1
    assert float((label[~on_ball] == 1).double().mean()) > 0.9


@pytest.mark.parametrize("distance", [3.0, 5.0])
def test_a_far_wall_is_one_plane_under_the_noise_of_the_sensor(
    distance: float, generator: torch.Generator
) -> None:
    noise = KINECT.deviation * torch.randn(240, 320, dtype=torch.float64, generator=generator)
    found = find_planes(cloud_of(1 / (1 / distance + noise), 290.0))
    assert len(found.planes) == 1
    assert angle_deg(found.planes[0, :3], torch.tensor([0.0, 0.0, -1.0], dtype=torch.float64)) < 1.0
    assert float((found.label == 1).double().mean()) > 0.8


def test_the_frame_of_the_points_does_not_matter() -> None:
    scene = picture(STACK)
    turn = scene.ground.world_from_camera
    seen, turned = find_planes(scene.cloud.rotated(turn.T)), find_planes(scene.cloud)
    assert torch.equal(seen.label, turned.label)
    assert torch.allclose(seen.planes[:, :3] @ turn.T, turned.planes[:, :3], atol=1e-6)
    assert torch.allclose(seen.planes[:, 3], turned.planes[:, 3], atol=1e-6)


def test_the_same_image_gives_the_same_planes_on_any_number_of_threads() -> None:
    cloud = observe(photograph(*BLOCKS).frame, given_ground).cloud
    given = [value for value in vars(cloud).values() if torch.is_tensor(value)]
    kept = [value.clone() for value in given]
    threads = torch.get_num_threads()
    try:
        torch.set_num_threads(1)
        one = find_planes(cloud)
        torch.set_num_threads(2)
        other = find_planes(cloud)
    finally:
        torch.set_num_threads(threads)
    assert torch.equal(one.label, other.label)
    assert torch.equal(one.planes, other.planes)
    assert all(torch.equal(a, b) for a, b in zip(kept, given, strict=True))


@pytest.mark.parametrize("size", [(1, 1), (3, 2), (8, 9), (60, 80)])
@pytest.mark.parametrize("distance", [0.0, 1.0])
def test_images_of_any_size_have_planes_or_none(size: tuple[int, int], distance: float) -> None:
    found = find_planes(cloud_of(torch.full(size, distance, dtype=torch.float64), 80.0))
    assert found.label.shape == size
    assert found.label.dtype == torch.int64
    assert int(found.label.max()) == len(found.planes)
    assert found.planes.shape == (int(size == (60, 80) and distance > 0), 4)


def test_a_closer_look_finds_what_a_first_one_misses() -> None:
    scene = picture(STACK)
    first = PlaneFinder(strides=(40,))(scene.cloud)
    assert 1 <= len(first.planes) < len(find_planes(scene.cloud).planes)


def test_planes_are_numbered_by_their_pixels_without_gaps() -> None:
    label = find_planes(observe(photograph(*BLOCKS).frame, given_ground).cloud).label
    pixels = torch.bincount(label.flatten())[1:]
    assert int(pixels.min()) > 0
    assert bool((pixels.diff() <= 0).all())


def test_what_is_not_measured_is_on_no_plane() -> None:
    scene = picture(STACK)
    hole = scene.cloud.valid.clone()
    hole[100:140, 100:140] = False
    depth = torch.where(hole, scene.frame.depth, 0.0)
    cloud = cloud_from_frame(replace(scene.frame, depth=depth))
    assert not find_planes(cloud).label[~hole].any()


def test_planes_of_which_no_pixel_is_looked_at_again_stay_as_they_are() -> None:
    cloud = picture(STACK).cloud
    found = find_planes(cloud)
    nowhere = torch.zeros_like(found.label)
    again = _fitted_again(found.planes, nowhere, cloud, torch.ones_like(cloud.depth))
    assert torch.equal(again, found.planes)


@pytest.mark.parametrize("name", ["frame00", "frame07"])
def test_an_image_full_of_holes_is_looked_at_without_a_word(real_scenes: Path, name: str) -> None:
    frame = read_scene(real_scenes / "apc" / name)
    found = find_planes(cloud_from_frame(frame))
    assert found.label.shape == frame.depth.shape
    assert int(found.label.max()) == len(found.planes)


@pytest.mark.parametrize("wrong", [{"reach": 0.0}, {"least_px": -1}, {"strides": (4, 0)}])
def test_numbers_must_be_above_zero(wrong: dict[str, object]) -> None:
    with pytest.raises(ValueError, match="above 0"):
        PlaneFinder(**wrong)  # type: ignore[arg-type]


@pytest.mark.parametrize("name", ["learn04", "learn20", "learn33"])
def test_a_real_table_is_one_plane(real_scenes: Path, name: str) -> None:
    frame = read_scene(real_scenes / "osd" / name)
    found = find_planes(cloud_from_frame(frame))
    assert frame.label is not None
    table = (frame.label == frame.background_ids[0]) & (frame.depth > 0)
    assert float((found.label[table] == found.label[table].mode().values).double().mean()) > 0.95
