"""Effects of a cheap camera: blur, vignetting, wrong exposure, noise, JPEG."""

from __future__ import annotations

import math
from io import BytesIO

import numpy as np
import torch
from PIL import Image
from torch import Tensor

_GREY = torch.tensor([0.2126, 0.7152, 0.0722])  # luminance of linear sRGB
_MIDDLE = 0.45  # the grey that contrast leaves as it is


def develop(light: Tensor, variety: float, generator: torch.Generator) -> Tensor:
    """Turn linear light into the picture of a webcam.

    Args:
        light: (H, W, 3) float32 linear RGB, in any unit: the exposure follows the light.
        variety: 0 for an average camera, 1 for good and bad ones.

    Returns:
        (H, W, 3) uint8 sRGB.
    """
    share = torch.rand(12, generator=generator)
    off = variety * (2.0 * share - 1.0)
    light = _blurred(light, 0.5 + 0.25 * float(off[0]))
    light = light * _vignette(light.shape, 0.25 + 0.25 * float(off[1]))[..., None]
    light = light * (1.0 + 0.1 * off[2:5])  # white balance
    # The exposure brings the median to a grey of 80 to 152 of 255, seldom quite right.
    level = float(_linear(torch.tensor((116.0 + 36.0 * float(off[5])) / 255.0)))
    light = light * (level / float((light * _GREY).sum(dim=-1).median().clamp(min=1e-6)))
    light = light + (0.004 + 0.004 * float(off[6]))  # stray light in the lens
    light = torch.lerp((light * _GREY).sum(dim=-1, keepdim=True), light, 0.95 + 0.25 * float(off[7]))
    light = light.clamp(min=0.0) + _noise(light, 0.013 * (1.0 + 0.8 * float(off[8])), generator)
    picture = _encoded(_shouldered(light.clamp(min=0.0)))
    # Cheap cameras turn up the contrast until what is bright is white, and what is dark is black.
    picture = _MIDDLE + (1.2 + 0.3 * float(off[11])) * (picture - _MIDDLE)
    sharp = picture + (0.5 + 0.5 * float(off[9])) * (picture - _blurred(picture, 1.0))
    return _squeezed((255.0 * sharp).round().clamp(0, 255).to(torch.uint8), 82 + round(12 * float(off[10])))


def _noise(light: Tensor, strength: float, generator: torch.Generator) -> Tensor:
    """Photon and amplifier noise, coarser and stronger in colour than in brightness."""
    fine, coarse = (torch.randn(light.shape, generator=generator) for _ in range(2))
    grain = 0.6 * fine + 1.4 * _blurred(coarse, 1.1)
    return strength * (0.015 + light.clamp(min=0.0)).sqrt() * grain


def _vignette(shape: torch.Size, strength: float) -> Tensor:
    """Brightness (H, W): the fourth power of a cosine, of which `strength` is what the corners lose."""
    rows, columns = (torch.linspace(-1.0, 1.0, length) for length in shape[:2])
    square = 0.5 * (rows[:, None] ** 2 + columns**2)
    return 1.0 / (1.0 + square * (1.0 / math.sqrt(1.0 - strength) - 1.0)) ** 2


def _blurred(image: Tensor, sigma: float) -> Tensor:
    """Smoothed along rows and columns by a Gaussian of 5 pixels."""
    kernel = [math.exp(-0.5 * (step / sigma) ** 2) for step in range(3)]
    near, far = (weight / (kernel[0] + 2 * kernel[1] + 2 * kernel[2]) for weight in kernel[1:])
    for dim in (0, 1):
        first, last = image.narrow(dim, 0, 1), image.narrow(dim, -1, 1)
        wide, size = torch.cat([first, first, image, last, last], dim=dim), image.shape[dim]
        image = (1.0 - 2 * near - 2 * far) * image
        for weight, starts in ((near, (1, 3)), (far, (0, 4))):
            for start in starts:
                image.add_(wide.narrow(dim, start, size), alpha=weight)
    return image


def _shouldered(light: Tensor) -> Tensor:
    """Linear up to a half; what is brighter nears 1 without ever being cut."""
    over = (light - 0.5).clamp(min=0.0)
    return light.clamp(max=0.5) + over / (1.0 + 2.0 * over)


def _linear(color: Tensor) -> Tensor:
    return ((color + 0.055) / 1.055) ** 2.4


def _encoded(light: Tensor) -> Tensor:
    """sRGB from linear light, both 0 to 1 (IEC 61966-2-1)."""
    return torch.where(light <= 0.0031308, 12.92 * light, 1.055 * light.clamp(min=1e-6) ** (1 / 2.4) - 0.055)


def _squeezed(picture: Tensor, quality: int) -> Tensor:
    """Through JPEG and back, as most cameras deliver."""
    buffer = BytesIO()
    Image.fromarray(picture.numpy()).save(buffer, format="JPEG", quality=quality)
    return torch.from_numpy(np.array(Image.open(buffer)))
