"""Paper to print on, and what is printed: washes of colour, words, small print, bar codes, pictures."""

from __future__ import annotations

import math
from functools import lru_cache
from typing import NamedTuple

import torch
from PIL import Image, ImageDraw, ImageFont

from blockstab.simulation.layouts.draws import choice, uniform, whole

Color = tuple[int, int, int]  # sRGB, 0 to 255

DOT = 0.0005  # metres from dot to dot of the printer
_SYLLABLES = ("BA", "CO", "DE", "FI", "GO", "KA", "LU", "MI", "NO", "PE", "RO", "SA", "TU", "VE", "ZU")
_EARTH: tuple[Color, ...] = ((150, 96, 48), (196, 146, 72), (120, 60, 40), (176, 60, 44), (108, 124, 60))


class Place(NamedTuple):
    """A rectangle on a sheet, in shares of its width and height from the top left."""

    left: float
    top: float
    width: float
    height: float


class Sheet:
    """A sheet of paper, seen upright, with a ground colour."""

    def __init__(self, width: float, height: float, ground: Color, dot: float = DOT) -> None:
        """Cut a sheet of `width` by `height` metres, to be printed in dots of `dot` metres."""
        self.extent, self.dot = (width, height), dot
        self.size = (max(2, round(width / dot)), max(2, round(height / dot)))
        self.image = Image.new("RGB", self.size, ground)

    @property
    def pen(self) -> ImageDraw.ImageDraw:
        """Draws on the sheet, in dots."""
        return ImageDraw.Draw(self.image)

    def dots(self, place: Place) -> tuple[float, float, float, float]:
        """Left, top, right and bottom of a place, in dots."""
        (width, height), p = self.size, place
        return p.left * width, p.top * height, (p.left + p.width) * width, (p.top + p.height) * height

    def block(self, place: Place, color: Color) -> None:
        """Fill a rectangle."""
        self.pen.rectangle(self.dots(place), fill=color)

    def oval(self, place: Place, color: Color) -> None:
        """Fill an ellipse."""
        self.pen.ellipse(self.dots(place), fill=color)

    def fade(self, color: Color, strength: float, turn: int) -> None:
        """Fade towards a colour: to the bottom, right, top or left for a `turn` of 0 to 3."""
        ramp = Image.linear_gradient("L").rotate(90 * turn).resize(self.size)
        self.image.paste(color, mask=ramp.point([round(strength * k) for k in range(256)]))

    def swoosh(self, color: Color, generator: torch.Generator) -> None:
        """A band or a big disc across the sheet."""
        width, height = self.size
        if whole(generator, 0, 1):
            left, top = uniform(generator, -0.6, 0.5), uniform(generator, -0.6, 0.5)
            self.oval(Place(left, top, 1.2, uniform(generator, 0.5, 1.3)), color)
            return
        top, slope, thick = (uniform(generator, *r) for r in ((0.0, 0.8), (-0.4, 0.4), (0.05, 0.4)))
        ends = ((0, top), (width, top + slope), (width, top + slope + thick), (0, top + thick))
        self.pen.polygon([(x, y * height) for x, y in ends], fill=color)

    def word(self, place: Place, color: Color, generator: torch.Generator, turn: float = 0.0) -> None:
        """A made-up name as large as fits, turned by `turn` degrees."""
        text = "".join(choice(generator, _SYLLABLES) for _ in range(whole(generator, 2, 3)))
        text = text.capitalize() if whole(generator, 0, 1) else text
        left, top, right, bottom = self.dots(place)
        high = min(bottom - top, 1.5 * (right - left) / len(text))
        if high < 4:
            return
        mask = Image.new("L", (max(1, round(right - left)), max(1, round(bottom - top))), 0)
        middle = (mask.width / 2, mask.height / 2)
        thick = whole(generator, 0, max(1, round(high / 14)))
        ImageDraw.Draw(mask).text(middle, text, 255, _font(round(high)), anchor="mm", stroke_width=thick)
        mask = mask.rotate(turn, Image.Resampling.BILINEAR)
        self.image.paste(color, (round(left), round(top)), mask)

    def small_print(self, place: Place, color: Color, generator: torch.Generator) -> None:
        """Rows of words too small to read, the last of a paragraph shorter."""
        left, top, right, bottom = self.dots(place)
        high = uniform(generator, 0.0012, 0.0028) / self.dot
        pen, y = self.pen, top
        while y + high < bottom:
            end = left + (right - left) * min(1.0, uniform(generator, 0.5, 1.6))
            words = (high * (0.8 + 3.0 * torch.rand(40, generator=generator))).tolist()
            x = left
            for k, long in enumerate(words):
                if x + long > end:
                    break
                # Letters of different heights: a row of even bars looks like no text.
                pen.rectangle((x, y + (0.35 * high if k % 3 else 0.0), x + long, y + high), fill=color)
                x += long + 0.7 * high
            y += 1.9 * high

    def bar_code(self, place: Place, generator: torch.Generator) -> None:
        """Black bars on white."""
        self.block(place, (236, 234, 228))
        left, top, right, bottom = self.dots(place)
        x, pen = left + 3.0, self.pen
        for bar, gap in (0.6 + 2.4 * torch.rand(60, 2, generator=generator)).tolist():
            if x + bar > right - 3:
                break
            pen.rectangle((x, top + 2, x + bar, bottom - 4), fill=(28, 26, 30))
            x += bar + gap

    def picture(self, place: Place, generator: torch.Generator) -> None:
        """Something like a photograph of food: a blurred ground with lumps that are lit from above."""
        left, top, right, bottom = (round(edge) for edge in self.dots(place))
        size = (max(1, right - left), max(1, bottom - top))
        tone = torch.tensor(choice(generator, _EARTH)) + 90 * torch.rand(5, 5, 3, generator=generator) - 30
        ground = Image.fromarray(tone.clamp(0, 255).to(torch.uint8).numpy()).resize(
            size, Image.Resampling.BICUBIC
        )
        pen, lump = ImageDraw.Draw(ground), choice(generator, _EARTH)
        radius = uniform(generator, 0.006, 0.016) / self.dot
        for x, y, shade in torch.rand(whole(generator, 0, 30), 3, generator=generator).tolist():
            cx, cy, r = x * size[0], y * size[1], radius * (0.7 + 0.6 * shade)
            for lift, part, light in ((0.15, 1.08, 0.45), (0.0, 1.0, 0.8 + 0.3 * shade), (-0.25, 0.6, 1.1)):
                box = (cx - part * r, cy - part * r + lift * r, cx + part * r, cy + part * r + lift * r)
                pen.ellipse(box, fill=shaded(lump, light))
        mask = Image.new("L", size, 255)
        if whole(generator, 0, 1):
            mask.paste(0, (0, 0, *size))
            ImageDraw.Draw(mask).ellipse((0, 0, *size), fill=255)
        self.image.paste(ground, (left, top), mask)


def shaded(color: Color, light: float) -> Color:
    """A colour made brighter or darker."""
    r, g, b = (min(255, max(0, round(light * part))) for part in color)
    return r, g, b


def legible(ground: Color, generator: torch.Generator) -> Color:
    """An ink that shows on the ground."""
    dark = ((34, 32, 40), (60, 30, 30), (24, 40, 84))
    pale = ((238, 234, 224), (240, 214, 120), (226, 230, 236))
    return choice(generator, pale if math.fsum(ground) < 380 else dark)


@lru_cache(maxsize=256)
def _font(size: int) -> ImageFont.FreeTypeFont | ImageFont.ImageFont:
    return ImageFont.load_default(size)
