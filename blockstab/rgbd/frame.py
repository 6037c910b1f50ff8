"""A colour image and a depth image of the same view, and the camera that took them."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from reprlib import repr as shown

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from blockstab.rgbd.noise import KINECT, DepthNoise, noise_from
from blockstab.rgbd.reading import (
    FrameError,
    ImageFile,
    Meta,
    color_file,
    depth_file,
    label_file,
    read_meta,
)

_UNITS_PER_METRE = {"mm": 1000.0, "0.1mm": 10000.0}
_MEDIAN_DEPTH = (0.1, 20.0)  # metres


@dataclass(frozen=True)
class Camera:
    """Pinhole intrinsics, pixels, and the noise of depth. OpenCV frame: x right, y down, z forward."""

    fx: float
    fy: float
    cx: float
    cy: float
    noise: DepthNoise = KINECT

    @property
    def intrinsics(self) -> dict[str, float]:
        """Focal lengths and principal point by name, as `meta.json` has them."""
        return {"fx": self.fx, "fy": self.fy, "cx": self.cx, "cy": self.cy}


@dataclass(frozen=True)
class Frame:
    """One RGB-D image.

    Args:
        name: the scene's name, for messages and output folders.
        color: (H, W, 3) uint8, RGB.
        depth: (H, W) float64, metres; 0 where the sensor gave none.
        camera: intrinsics of both images.
        label: (H, W) int64 instance ids, 0 = no label; None where the scene has none.
        background_ids: label ids of table, floor, walls.
        up_camera: (3,) float64 true up direction in the camera frame, where the scene knows it.
    """

    name: str
    color: Tensor
    depth: Tensor
    camera: Camera
    label: Tensor | None = None
    background_ids: tuple[int, ...] = ()
    up_camera: Tensor | None = None


def read_scene(folder: Path) -> Frame:
    """Read a scene folder.

    It holds `color.png`, `depth.png`, `meta.json` and, optionally, `label.png` (instance ids, one channel of
    8 or 16 bits, 0 = none). `meta.json` gives `fx`, `fy`, `cx`, `cy` in pixels and `depth_unit`; it may give
    `up_camera`, three numbers, `background_ids`, a list of label ids, and `depth_noise`, as `noise_from` takes
    it, that of a Kinect where not given. The images are as `read_images`
    wants them.

    Raises:
        FrameError: a file is missing, damaged or not what it should be; the message names it.
    """
    meta_path, label_path = folder / "meta.json", folder / "label.png"
    meta = read_meta(meta_path)
    fx, fy, cx, cy = (meta.number(key) for key in ("fx", "fy", "cx", "cy"))
    camera = Camera(fx, fy, cx, cy, _noise(meta))
    background_ids, up = meta.ids("background_ids"), meta.direction("up_camera")
    depth = depth_file(folder / "depth.png")
    color, name = color_file(folder / "color.png"), folder.resolve().name
    frame = _read(color, depth, camera, meta.values.get("depth_unit"), name, str(meta_path))
    label = _read_label(label_path, depth) if label_path.exists() else None
    return replace(frame, label=label, background_ids=background_ids, up_camera=up)


def read_images(
    color: Path, depth: Path, camera: Camera, depth_unit: str = "mm", name: str | None = None
) -> Frame:
    """Read a colour and a depth image that need not lie in a scene folder.

    Args:
        color: PNG or JPEG of 8 bits a channel; greyscale and palettes become RGB, transparency is dropped.
        depth: PNG of one channel of 16 bits, pixel upon pixel with `color`; 0 where the sensor gave none.
        camera: intrinsics of both.
        depth_unit: "mm" or "0.1mm".
        name: the scene's name; the colour file's, less its ending, where not given.

    Raises:
        FrameError: a file is missing, damaged, over 64 megapixels or not what it should be; the median depth
            lies outside 0.1 to 20 m; or no camera with these intrinsics takes an image of this size.
    """
    return _read(color_file(color), depth_file(depth), camera, depth_unit, name or color.stem, "camera")


def _noise(meta: Meta) -> DepthNoise:
    """That of a Kinect where the scene does not say."""
    if "depth_noise" not in meta.values:
        return KINECT
    try:
        return noise_from(meta.values["depth_noise"])
    except ValueError as error:
        raise FrameError(f"{meta.path}: {error}; correct it, or leave it out.") from None


def _read(color: ImageFile, depth: ImageFile, camera: Camera, unit: object, name: str, source: str) -> Frame:
    if not isinstance(unit, str) or unit not in _UNITS_PER_METRE:
        raise FrameError(
            f"{source}: depth_unit must be mm or 0.1mm, but it is {shown(unit)}; "
            f"state the unit {depth.path.name} is in, or convert it to millimetres."
        )
    return decoded(
        color, depth, camera, lambda raw: raw.astype(np.float64) / _UNITS_PER_METRE[unit], name, source, unit
    )


def decoded(
    color: ImageFile,
    depth: ImageFile,
    camera: Camera,
    metres_of: Callable[[NDArray[np.uint16]], NDArray[np.float64]],
    name: str,
    source: str,
    unit: str = "mm",
) -> Frame:
    """Check what the headers and `source`, which gave the camera, say; then decode.

    Args:
        metres_of: what the numbers of the depth image mean; 0 must stay 0.
        unit: of the depth image, for messages.

    Raises:
        FrameError: as `read_images`.
    """
    check_same_size(color, depth)
    _check_camera(camera, depth, source)
    metres = metres_of(np.asarray(depth.decode()).astype(np.uint16))
    check_depth(metres, depth.path, unit)
    image = color.decode()
    if "transparency" in image.info:
        image = image.convert("RGBA")
    return Frame(name, torch.from_numpy(np.array(image.convert("RGB"))), torch.from_numpy(metres), camera)


def _read_label(path: Path, depth: ImageFile) -> Tensor:
    """(H, W) int64 instance ids."""
    file = label_file(path)
    check_same_size(file, depth)
    return torch.from_numpy(np.asarray(file.decode()).astype(np.int64))


def check_same_size(file: ImageFile, depth: ImageFile) -> None:
    """See that an image lies pixel upon pixel with the depth, by what both headers say.

    Raises:
        FrameError: it has another size.
    """
    if (file.width, file.height) != (depth.width, depth.height):
        raise FrameError(
            f"{file.path}: must have the {depth.width} x {depth.height} pixels of {depth.path.name}, but has "
            f"{file.width} x {file.height}; register the images to one camera."
        )


def _check_camera(camera: Camera, image: ImageFile, source: str) -> None:
    for key in ("fx", "fy"):
        value = getattr(camera, key)
        if not (math.isfinite(value) and value > 0):
            raise FrameError(
                f"{source}: {key} must be a positive number of pixels, but it is {value}; correct it."
            )
    for key, extent in (("cx", image.width), ("cy", image.height)):
        value = getattr(camera, key)
        if not 0 < value < extent:
            raise FrameError(
                f"{source}: {key} must lie inside the image, between 0 and {extent}, but it is {value}; "
                "give the intrinsics for images of this size."
            )


def check_depth(metres: NDArray[np.float64], path: Path, unit: str) -> None:
    """See that there is depth, in a unit that can be right.

    Args:
        metres: (H, W) float64, 0 = missing.
        path: the file it came from, in `unit`; for messages.

    Raises:
        FrameError: nothing is valid, or the median lies outside 0.1 to 20 m.
    """
    valid = metres[metres > 0]
    if not valid.size:
        raise FrameError(
            f"{path} holds 0 valid pixels of {metres.size}; depth must be there somewhere: was it in metres "
            "when it was rounded to integers?"
        )
    median = float(np.median(valid))
    if not _MEDIAN_DEPTH[0] <= median <= _MEDIAN_DEPTH[1]:
        raise FrameError(
            f"{path}: the median depth must be between 0.1 and 20 m, but in {unit} it is {median:.4g} m; "
            "state the unit the file is in, or convert it to millimetres."
        )
