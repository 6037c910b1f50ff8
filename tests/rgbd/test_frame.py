"""Reading scenes, and refusing what is none."""

from __future__ import annotations

import struct
import zlib
from pathlib import Path

import numpy as np
import pytest
import torch
from PIL import Image

from blockstab.rgbd.frame import Camera, read_images, read_scene
from blockstab.rgbd.reading import FrameError
from tests.tolerance import EXACT

CAMERA = Camera(10.0, 10.0, 3.5, 2.5)
GREY = np.arange(48, dtype=np.uint8).reshape(6, 8)
DEPTH = np.full((6, 8), 1000, dtype=np.uint16)


def test_convention_depth_is_metres(scene):
    scene.image("depth.png", np.arange(48, dtype=np.uint16).reshape(6, 8) * 50)
    depth = read_scene(scene.path).depth
    assert depth.dtype == torch.float64
    assert depth.flatten()[[0, 1, 20]].tolist() == [0.0, 0.05, 1.0]


def test_tenths_of_millimetres_are_metres_too(scene):
    scene.meta(depth_unit="0.1mm")
    scene.image("depth.png", DEPTH * 5)
    assert read_scene(scene.path).depth.unique().tolist() == [0.5]


def test_a_scene_without_optional_parts_has_none_of_them(scene):
    frame = read_scene(scene.path)
    assert (frame.label, frame.background_ids, frame.up_camera) == (None, (), None)
    assert frame.name == scene.path.name
    assert frame.camera == CAMERA
    assert frame.color.shape == (6, 8, 3)


def test_optional_parts_are_read(scene):
    scene.meta(background_ids=[1, 7], up_camera=[0, -3, -4])
    scene.image("label.png", GREY.astype(np.uint16) * 100)
    frame = read_scene(scene.path)
    assert frame.background_ids == (1, 7)
    assert frame.up_camera.tolist() == pytest.approx([0.0, -0.6, -0.8], abs=EXACT)
    assert frame.label.dtype == torch.int64
    assert (frame.label.numpy() == GREY.astype(np.int64) * 100).all()


@pytest.mark.parametrize("mode", ["L", "P"])
def test_labels_of_8_bits_keep_their_ids(scene, mode):
    label = Image.fromarray(GREY)
    if mode == "P":
        label = Image.fromarray(GREY, "L").convert("P")
        label.putpalette([255, 0, 0] * 256)
    label.save(scene.path / "label.png")
    assert (read_scene(scene.path).label.numpy() == GREY).all()


@pytest.mark.parametrize("mode", ["RGB", "RGBA", "L", "LA", "P", "1"])
def test_any_colour_image_of_8_bits_becomes_rgb(scene, mode):
    picture = Image.fromarray(GREY).convert(mode)
    picture.save(scene.path / "color.png")
    assert (read_scene(scene.path).color.numpy() == np.asarray(picture.convert("RGB"))).all()


def test_a_palette_with_transparency_becomes_rgb_without_a_warning(scene, recwarn):
    Image.fromarray(GREY).convert("P").save(scene.path / "color.png", transparency=bytes([0, 128]))
    assert read_scene(scene.path).color.shape == (6, 8, 3)
    assert not recwarn.list


def test_loose_images_make_the_frame_that_their_scene_makes(scene):
    frame = read_images(scene.path / "color.png", scene.path / "depth.png", CAMERA, name="mine")
    folder = read_scene(scene.path)
    assert frame.name == "mine"
    assert torch.equal(frame.color, folder.color)
    assert torch.equal(frame.depth, folder.depth)


def test_a_jpeg_is_a_colour_image_and_gives_the_frame_its_name(scene):
    path = scene.image("view.jpg", np.full((6, 8, 3), 90, dtype=np.uint8))
    frame = read_images(path, scene.path / "depth.png", CAMERA)
    assert frame.name == "view"
    assert (frame.color.int() - 90).abs().max() <= 2


@pytest.mark.parametrize("name", ["color.png", "depth.png", "meta.json"])
def test_a_missing_file_is_named(scene, name):
    (scene.path / name).unlink()
    with pytest.raises(FrameError, match=f"{name}: must be a readable file.*No such file.*check the path"):
        read_scene(scene.path)


def test_a_folder_in_place_of_a_file_is_refused(scene):
    (scene.path / "label.png").mkdir()
    with pytest.raises(FrameError, match=r"label.png: must be a readable file.*Is a directory"):
        read_scene(scene.path)


@pytest.mark.parametrize("name", ["color.png", "label.png"])
def test_images_of_another_size_are_refused(scene, name):
    scene.image(name, np.ones((6, 9), dtype=np.uint8))
    with pytest.raises(FrameError, match=rf"{name}: must have the 8 x 6 pixels of depth.png, but has 9 x 6"):
        read_scene(scene.path)


@pytest.mark.parametrize(
    ("pixels", "came"),
    [
        (GREY, "8-bit greyscale"),
        (np.dstack([GREY] * 3), "8-bit RGB"),
        (np.dstack([GREY] * 4), "8-bit RGBA"),
    ],
)
def test_depth_of_8_bits_is_refused(scene, pixels, came):
    scene.image("depth.png", pixels)
    with pytest.raises(
        FrameError, match=f"depth.png: must be a PNG of one channel of 16 bits.*it is {came};"
    ):
        read_scene(scene.path)


def test_depth_as_float_is_refused(scene):
    path = scene.image("depth.tiff", DEPTH.astype(np.float32))
    with pytest.raises(FrameError, match=r"depth.tiff: must be a PNG of one channel .* neither PNG nor JPEG"):
        read_images(scene.path / "color.png", path, CAMERA)


def test_a_jpeg_is_no_depth_and_no_label(scene):
    path = scene.image("grey.jpg", GREY)
    with pytest.raises(FrameError, match=r"grey.jpg: must be a PNG of one channel of 16 bits.*8-bit JPEG"):
        read_images(scene.path / "color.png", path, CAMERA)
    path.rename(scene.path / "label.png")
    with pytest.raises(
        FrameError, match=r"label.png: must be a PNG of one channel of 8 or 16 bits.*8-bit JPEG"
    ):
        read_scene(scene.path)


@pytest.mark.parametrize("mode", ["RGB", "1"])
def test_labels_of_several_channels_or_too_few_bits_are_refused(scene, mode):
    Image.fromarray(GREY).convert(mode).save(scene.path / "label.png")
    with pytest.raises(FrameError, match=r"label.png: must be a PNG of one channel of 8 or 16 bits"):
        read_scene(scene.path)


def test_colour_of_16_bits_is_refused(scene):
    scene.image("color.png", DEPTH)
    with pytest.raises(
        FrameError, match=r"color.png: must be a PNG or JPEG of 8 bits a channel.*16-bit greys"
    ):
        read_scene(scene.path)


def test_depth_without_a_valid_pixel_is_refused(scene):
    scene.image("depth.png", DEPTH * 0)
    with pytest.raises(FrameError, match=r"depth.png holds 0 valid pixels of 48; depth must"):
        read_scene(scene.path)


@pytest.mark.parametrize(("value", "came"), [(1, "0.001 m"), (60000, "60 m")])
def test_depth_that_cannot_be_millimetres_is_refused(scene, value, came):
    scene.image("depth.png", np.full((6, 8), value, dtype=np.uint16))
    with pytest.raises(
        FrameError, match=f"depth.png: the median depth must .* but in mm it is {came}; state the"
    ):
        read_scene(scene.path)


@pytest.mark.parametrize("unit", ["m", "cm", 1, None, ["mm"], ...])
def test_an_unknown_depth_unit_is_refused(scene, unit):
    scene.meta(depth_unit=unit)
    with pytest.raises(FrameError, match=r"meta.json: depth_unit must be mm or 0.1mm, but it is"):
        read_scene(scene.path)


@pytest.mark.parametrize("key", ["fx", "fy", "cx", "cy"])
@pytest.mark.parametrize(
    "value", [float("nan"), float("inf"), 0, -5, "525", None, True, [525.0], 10**400, ...], ids=str
)
def test_intrinsics_that_no_camera_has_are_refused(scene, key, value):
    scene.meta(**{key: value})
    with pytest.raises(FrameError, match=f"meta.json: {key} must (be a|lie)"):
        read_scene(scene.path)


def test_intrinsics_for_another_resolution_are_refused(scene):
    scene.meta(fx=1000.0, fy=1000.0, cx=320.0, cy=240.0)
    with pytest.raises(
        FrameError, match=r"cx must lie inside the image, between 0 and 8, but it is 320.0; give"
    ):
        read_scene(scene.path)


def test_a_bad_camera_for_loose_images_is_refused(scene):
    with pytest.raises(FrameError, match="camera: fy must be a positive number of pixels, but it is nan"):
        read_images(scene.path / "color.png", scene.path / "depth.png", Camera(10.0, float("nan"), 3.5, 2.5))


@pytest.mark.parametrize(
    "text", [b"", b"{", b'{"fx": 1,}', b"\xff\xfe\xfd", b"[" * 200_000, b'{"fx": ' + b"1" * 5000 + b"}"]
)
def test_text_that_is_no_json_is_refused(scene, text):
    (scene.path / "meta.json").write_bytes(text)
    with pytest.raises(FrameError, match=r"meta.json: must be JSON, but cannot be read as such"):
        read_scene(scene.path)


def test_json_that_is_no_object_is_refused(scene):
    (scene.path / "meta.json").write_text("[525.0]")
    with pytest.raises(FrameError, match=r"meta.json: must be a JSON object, but it is \[525.0\]"):
        read_scene(scene.path)


def test_a_huge_meta_file_is_refused(scene):
    (scene.path / "meta.json").write_bytes(b" " * (16 * 2**20) + b"{}")
    with pytest.raises(FrameError, match=r"meta.json: must have at most 16 MiB"):
        read_scene(scene.path)


@pytest.mark.parametrize(
    "up", [None, [0, 0, 0], [0, 1], [0, 1, 0, 0], ["a", 1, 0], [0, float("nan"), 1], "up"]
)
def test_an_up_that_is_no_direction_is_refused(scene, up):
    scene.meta(up_camera=up)
    with pytest.raises(
        FrameError, match=r"meta.json: up_camera must be three finite numbers, not all zero, but"
    ):
        read_scene(scene.path)


@pytest.mark.parametrize("ids", [1, "1", [1.0], ["1"], [True], [0], [-1], None])
def test_background_ids_that_are_no_label_ids_are_refused(scene, ids):
    scene.meta(background_ids=ids)
    with pytest.raises(FrameError, match=r"meta.json: background_ids must be a list of label ids"):
        read_scene(scene.path)


@pytest.mark.parametrize("name", ["color.png", "depth.png", "label.png"])
def test_an_image_over_64_megapixels_is_refused_by_its_header_alone(scene, name):
    bits, channels = (8, 2) if name == "color.png" else (16, 0)
    header = struct.pack(">IIBB", 8001, 8000, bits, channels)
    (scene.path / name).write_bytes(b"\x89PNG\r\n\x1a\n\0\0\0\x0dIHDR" + header)
    with pytest.raises(FrameError, match=rf"{name}: must have at most 64 megapixels.*8001 x 8000; scale"):
        read_scene(scene.path)


def test_an_image_too_large_for_its_bytes_is_refused_before_it_is_decoded(scene):
    path = scene.image("depth.png", DEPTH)
    data = bytearray(path.read_bytes())
    data[16:24] = struct.pack(">II", 8000, 8000)
    data[29:33] = struct.pack(">I", zlib.crc32(data[12:29]))
    path.write_bytes(data)
    scene.image("color.png", np.zeros((8000, 8000), dtype=np.uint8))  # as well packed as can be, and sound
    with pytest.raises(
        FrameError, match=rf"depth.png: .* its {len(data)} bytes cannot hold the 8000 x 8000 pix"
    ):
        read_scene(scene.path)


def test_a_jpeg_over_64_megapixels_is_refused_by_its_header_alone(scene, recwarn):
    path = scene.image("color.jpg", np.zeros((16, 16), dtype=np.uint8))
    data = path.read_bytes()
    size = data.index(b"\xff\xc0") + 5
    path.write_bytes(data[:size] + struct.pack(">HH", 65000, 65000) + data[size + 4 :])
    with pytest.raises(FrameError, match=r"color.jpg: must have at most 64 megapixels.*65000 x 65000"):
        read_images(path, scene.path / "depth.png", CAMERA)
    assert not recwarn.list


@pytest.mark.parametrize("name", ["color.png", "depth.png", "label.png"])
@pytest.mark.parametrize("damage", ["truncated", "one bit flipped"])
def test_a_damaged_image_is_refused(scene, name, damage):
    noise = np.random.default_rng(0).integers(900, 1100, (6, 8))
    scene.image(name, noise.astype(np.uint8 if name == "color.png" else np.uint16))
    data = bytearray((scene.path / name).read_bytes())
    if damage == "truncated":
        del data[-30:]
    else:
        data[data.index(b"IDAT") + 20] ^= 4
    (scene.path / name).write_bytes(data)
    with pytest.raises(FrameError, match=f"{name}: must be a whole image, but is truncated or corrupt"):
        read_scene(scene.path)


def test_an_error_is_one_line(scene):
    scene.meta(fx="5\n25" * 1000)
    with pytest.raises(FrameError) as caught:
        read_scene(scene.path)
    assert "\n" not in str(caught.value)
    assert len(str(caught.value)) < 300


def test_every_real_scene_is_read(real_scenes: Path):
    for meta in sorted(real_scenes.glob("*/*/meta.json")):
        frame = read_scene(meta.parent)
        assert frame.color.shape[:2] == frame.depth.shape
        assert (frame.label is None) == (not (meta.parent / "label.png").exists())
