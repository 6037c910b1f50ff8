"""Files of an RGB-D image: what each has to be, checked before a pixel is decoded."""

from __future__ import annotations

import json
import math
import struct
import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from reprlib import repr as shown
from typing import Any

import torch
from PIL.Image import Image
from PIL.JpegImagePlugin import JpegImageFile
from PIL.PngImagePlugin import PngImageFile
from torch import Tensor

_MOST_PIXELS = 64_000_000
_MOST_DEFLATED = 1032  # bytes that one can stand for (zlib's technical details)
_MOST_JSON_BYTES = 16 * 2**20
_PNG_CHANNELS = {0: "greyscale", 2: "RGB", 3: "palette", 4: "greyscale with alpha", 6: "RGBA"}
# What Pillow raises on damaged files.
_DAMAGE = (OSError, SyntaxError, ValueError, EOFError, IndexError, TypeError, struct.error)


class FrameError(ValueError):
    """A file that is no part of an RGB-D image; its message says what must hold, what came and what to do."""


@dataclass(frozen=True)
class ImageFile:
    """Header of an image file: its size in pixels, the bits of a channel, and its channels."""

    path: Path
    width: int
    height: int
    bits: int
    channels: str

    def decode(self) -> Image:
        """The image; a truncated or corrupt file raises `FrameError`."""
        try:
            with self.path.open("rb") as file:
                # Pillow decodes many a PNG with flipped bits in silence; only `verify` sees the checksums.
                if self.channels != "JPEG":
                    PngImageFile(file).verify()
                    file.seek(0)
                image: Image = JpegImageFile(file) if self.channels == "JPEG" else PngImageFile(file)
                image.load()
        except _DAMAGE as error:
            raise FrameError(
                f"{self.path}: must be a whole image, but is truncated or corrupt ({error}); copy it again."
            ) from error
        return image


def color_file(path: Path) -> ImageFile:
    """A PNG or JPEG of 8 bits a channel."""
    return _image_file(path, "a PNG or JPEG of 8 bits a channel", lambda file: file.bits <= 8)


def depth_file(path: Path) -> ImageFile:
    """A PNG of one channel of 16 bits."""
    wanted = "a PNG of one channel of 16 bits, depth in whole millimetres"
    return _image_file(path, wanted, lambda file: (file.bits, file.channels) == (16, "greyscale"))


def label_file(path: Path) -> ImageFile:
    """A PNG of one channel of 8 or 16 bits."""
    channels = ("greyscale", "palette")
    wanted = "a PNG of one channel of 8 or 16 bits, an instance id in each pixel"
    return _image_file(path, wanted, lambda file: file.bits in (8, 16) and file.channels in channels)


@dataclass(frozen=True)
class Meta:
    """The JSON object that describes an image; a value not of the kind asked for raises `FrameError`."""

    path: Path
    values: dict[str, Any]

    def number(self, key: str) -> float:
        """A finite number, which must be there."""
        number = finite(self.values.get(key))
        if math.isnan(number):
            came = shown(self.values[key]) if key in self.values else "missing"
            raise FrameError(f"{self.path}: {key} must be a finite number, but it is {came}; correct it.")
        return number

    def ids(self, key: str) -> tuple[int, ...]:
        """Label ids; none where there is no such key."""
        ids = self.values.get(key, [])
        if not isinstance(ids, list) or not all(type(label) is int and label > 0 for label in ids):
            raise FrameError(
                f"{self.path}: {key} must be a list of label ids, integers from 1, but it is {shown(ids)}; "
                "list ids of label.png, or leave it out."
            )
        return tuple(ids)

    def direction(self, key: str) -> Tensor | None:
        """(3,) float64 unit vector; None where there is no such key."""
        if key not in self.values:
            return None
        value = self.values[key]
        numbers = [finite(number) for number in value] if isinstance(value, list) else []
        length = math.hypot(*numbers)
        if len(numbers) != 3 or not 0 < length < math.inf:
            raise FrameError(
                f"{self.path}: {key} must be three finite numbers, not all zero, but it is {shown(value)}; "
                "give a direction in the camera frame, or leave it out."
            )
        return torch.tensor(numbers, dtype=torch.float64) / length


def read_meta(path: Path) -> Meta:
    """Read a JSON object of at most 16 MiB."""
    values = read_json(path)
    if not isinstance(values, dict):
        raise FrameError(
            f"{path}: must be a JSON object, but it is {shown(values)}; put braces around the values."
        )
    return Meta(path, values)


def read_json(path: Path) -> Any:
    """Read JSON of at most 16 MiB; the worst of it takes forty times that in memory."""
    text = _read_bytes(path, _MOST_JSON_BYTES + 1)
    if len(text) > _MOST_JSON_BYTES:
        raise FrameError(f"{path}: must have at most 16 MiB, but has more; is it the right file?")
    try:
        return json.loads(text)
    except (ValueError, RecursionError) as error:
        raise FrameError(
            f"{path}: must be JSON, but cannot be read as such ({error}); correct it."
        ) from error


def finite(value: object) -> float:
    """The value as a float; NaN where it is no finite number."""
    if isinstance(value, bool) or not isinstance(value, int | float) or not abs(value) <= sys.float_info.max:
        return math.nan
    return float(value)


def _image_file(path: Path, wanted: str, fits: Callable[[ImageFile], bool]) -> ImageFile:
    """The header of an image that is what is wanted, and small enough to decode."""
    file = _header(path)
    if file is None or not fits(file):
        came = "neither PNG nor JPEG" if file is None else f"{file.bits}-bit {file.channels}"
        raise FrameError(f"{path}: must be {wanted}, but it is {came}; convert it.")
    if not 0 < file.width * file.height <= _MOST_PIXELS:
        raise FrameError(
            f"{path}: must have at most 64 megapixels, but its header says {file.width} x {file.height}; "
            "scale the images down, and the intrinsics with them."
        )
    _check_bytes(file)
    return file


def _check_bytes(file: ImageFile) -> None:
    """See that a PNG has bytes enough for its pixels, before these take memory."""
    size = file.path.stat().st_size
    if file.channels != "JPEG" and size * _MOST_DEFLATED < file.width * file.height * file.bits // 8:
        raise FrameError(
            f"{file.path}: must be a whole image, but its {size} bytes cannot hold the {file.width} x {file.height} "
            "pixels that its header says; copy it again."
        )


def _header(path: Path) -> ImageFile | None:
    """The header of an image file; None where the file is neither PNG nor JPEG."""
    head = _read_bytes(path, 26)
    if len(head) == 26 and head.startswith(b"\x89PNG\r\n\x1a\n") and head[12:16] == b"IHDR":
        width, height, bits, channels = struct.unpack(">IIBB", head[16:])
        return ImageFile(path, width, height, bits, _PNG_CHANNELS.get(channels, "unknown"))
    try:
        with path.open("rb") as file:
            return ImageFile(path, *JpegImageFile(file).size, 8, "JPEG")
    except _DAMAGE:
        return None


def _read_bytes(path: Path, most: int) -> bytes:
    """The first bytes of a file."""
    try:
        with path.open("rb") as file:
            return file.read(most)
    except OSError as error:
        raise FrameError(
            f"{path}: must be a readable file, but cannot be opened ({error.strerror}); check the path."
        ) from error
