"""Drawing for the films: colours, anti-aliased text and lines on RGB images, uint8 (height, width, 3).

Pillow draws a text once, with the font that comes with matplotlib; later it is blended from a cache.
"""

from collections.abc import Sequence
from functools import lru_cache
from pathlib import Path
from typing import Literal, NamedTuple

import cv2
import numpy as np
from PIL import Image, ImageDraw, ImageFont

Colour = tuple[int, int, int]

GROUND: Colour = (19, 23, 29)
PANEL: Colour = (30, 36, 45)
FAINT: Colour = (66, 75, 88)
GREY: Colour = (176, 186, 199)
WHITE: Colour = (238, 241, 245)
GREEN: Colour = (84, 222, 130)
RED: Colour = (226, 108, 100)
PERSON: Colour = (248, 200, 158)  # the caregiver: face and gaze
ROBOT: Colour = (150, 208, 255)  # the robot and its gaze
LEARNED: Colour = (190, 160, 255)  # whatever comes from learning
TITLE, TEXT, SMALL = 20, 17, 15
"""Sizes of text, pixels of an image 1280 wide: a film is also watched on a phone, a third as wide."""
_READABLE = 118  # least luminance (0..255) of ink on the dark ground
_SUBPIXEL = 4  # bits of fraction in coordinates given to OpenCV


class Box(NamedTuple):
    """A rectangle of the image, pixels."""

    x: int
    y: int
    width: int
    height: int

    def of(self, image: np.ndarray) -> np.ndarray:
        """The part of ``image`` in this rectangle, as a view."""
        return image[self.y : self.y + self.height, self.x : self.x + self.width]


def ink_of(rgb: Sequence[float]) -> Colour:
    """An object's colour (0..1) with so much white that it is readable on the dark ground."""
    colour = 255 * np.asarray(rgb, float)
    luminance = colour @ (0.2126, 0.7152, 0.0722)
    if luminance < _READABLE:
        colour += (255 - colour) * (_READABLE - luminance) / (255 - luminance)
    red, green, blue = (round(float(value)) for value in colour)
    return red, green, blue


def paler(colour: Colour) -> Colour:
    """The colour half way to white, to be seen on things of ``colour``."""
    red, green, blue = ((255 + value) // 2 for value in colour)
    return red, green, blue


@lru_cache
def _font(size: int, bold: bool) -> ImageFont.FreeTypeFont:
    import matplotlib  # only its folder of fonts is needed, and only where words are drawn

    name = "DejaVuSans-Bold.ttf" if bold else "DejaVuSans.ttf"
    return ImageFont.truetype(str(Path(matplotlib.get_data_path()) / "fonts" / "ttf" / name), size)


@lru_cache(maxsize=1024)
def _mask(text: str, size: int, bold: bool) -> np.ndarray:
    """(h, w, 1) uint16, 0..256: how much ink each pixel of the text takes. The height depends on the size alone."""
    font = _font(size, bold)
    ascent, descent = font.getmetrics()
    image = Image.new("L", (max(1, int(np.ceil(font.getlength(text)))), ascent + descent))
    ImageDraw.Draw(image).text((0, 0), text, fill=255, font=font)
    return (np.asarray(image, np.int32)[..., None] * 257 >> 8).astype(np.uint16)


@lru_cache(maxsize=1024)
def _ink(text: str, size: int, bold: bool, colour: Colour) -> np.ndarray:
    """(h, w, 3) uint16: what the text adds to an image, times 256."""
    return _mask(text, size, bold) * np.array(colour, np.uint16)


@lru_cache(maxsize=64)
def _filled(shape: tuple[int, ...], colour: Colour) -> np.ndarray:
    """An image of one colour."""
    return np.full(shape, colour, np.uint8)


def width_of(text: str, size: int = 14, bold: bool = False) -> int:
    """Width (pixels) that ``write`` will need.

    Args:
        text: One line.
        size: Of the letters, pixels.
        bold: Whether it is written in bold.
    """
    return int(_mask(text, size, bold).shape[1])


def fitting(text: str, width: float, sizes: Sequence[int], bold: bool = False) -> int:
    """The first of ``sizes`` in which ``text`` is at most ``width`` pixels wide, or the last.

    Args:
        text: One line.
        width: Pixels that there are.
        sizes: Of the letters, pixels, the preferred one first.
        bold: Whether it is written in bold.
    """
    return next((size for size in sizes if width_of(text, size, bold) <= width), sizes[-1])


def write(
    image: np.ndarray,
    x: float,
    y: float,
    text: str,
    colour: Colour = WHITE,
    size: int = 14,
    bold: bool = False,
    align: Literal["left", "centre", "right"] = "left",
) -> int:
    """Draw one line of text in place; what lies outside of the image is cut off.

    Args:
        image: (height, width, 3) uint8.
        x: Left end, centre or right end of the text, by ``align``; pixels.
        y: Its top, pixels.
        text: The line.
        colour: Of the text.
        size: Of the font, pixels.
        bold: Whether the font is bold.
        align: Which part of the text is at ``x``.

    Returns:
        The x at which the text ends, pixels.
    """
    mask = _mask(text, size, bold)
    left = round(x - {"left": 0, "centre": 0.5, "right": 1}[align] * mask.shape[1])
    top, end = round(y), int(left + mask.shape[1])
    skip_x, skip_y = max(0, -left), max(0, -top)
    area = image[top + skip_y : top + mask.shape[0], left + skip_x : end] if end > 0 else image[:0, :0]
    if area.size:
        part = slice(skip_y, skip_y + area.shape[0]), slice(skip_x, skip_x + area.shape[1])
        area[:] = (area * (256 - mask[part]) + _ink(text, size, bold, colour)[part]) >> 8
    return end


def shade(area: np.ndarray, colour: Colour, share: float) -> None:
    """Mix ``share`` (0..1) of a colour into an area of an image, in place.

    Args:
        area: Part of an image (h, w, 3) uint8.
        colour: Red, green and blue, 0 to 255.
        share: Of the colour, 0 to 1.
    """
    cv2.addWeighted(area, 1 - share, _filled(area.shape, colour), share, 0, dst=area)


def lines(
    image: np.ndarray, points: Sequence[np.ndarray], colour: Colour, thickness: int = 1, closed: bool = False
) -> None:
    """Draw anti-aliased polylines.

    Args:
        image: (height, width, 3) uint8.
        points: Of each line, (k, 2): x and y, pixels with fractions.
        colour: Of the lines.
        thickness: Of the lines, pixels.
        closed: Whether each line returns to its first point.
    """
    fixed = [np.round(np.asarray(path, float) * (1 << _SUBPIXEL)).astype(np.int32) for path in points]
    cv2.polylines(image, fixed, closed, colour, thickness, cv2.LINE_AA, _SUBPIXEL)


def disc(image: np.ndarray, centre: np.ndarray, radius: float, colour: Colour, thickness: int = cv2.FILLED) -> None:
    """Draw an anti-aliased circle around ``centre`` (x, y), pixels; filled unless a thickness is given.

    Args:
        image: (h, w, 3) uint8, drawn on.
        centre: (2,) x and y, pixels.
        radius: Pixels.
        colour: Red, green and blue, 0 to 255.
        thickness: Of the line, pixels; filled by default.
    """
    x, y = (round(float(value) * (1 << _SUBPIXEL)) for value in centre)
    cv2.circle(image, (x, y), round(radius * (1 << _SUBPIXEL)), colour, thickness, cv2.LINE_AA, _SUBPIXEL)


def brackets(image: np.ndarray, centre: np.ndarray, half: float, colour: Colour, thickness: int = 2) -> None:
    """Draw the four corners of a square around ``centre`` (x, y); ``half`` its side, pixels.

    Args:
        image: (h, w, 3) uint8, drawn on.
        centre: (2,) x and y, pixels.
        half: Half of the square's side, pixels.
        colour: Red, green and blue, 0 to 255.
        thickness: Of the lines, pixels.
    """
    corner = np.array([(-1.0, -0.45), (-1, -1), (-0.45, -1)]) * half
    paths = [centre + corner * flip for flip in ((1, 1), (-1, 1), (1, -1), (-1, -1))]
    lines(image, paths, colour, thickness)


def tick(image: np.ndarray, centre: np.ndarray, size: float, colour: Colour, thickness: int) -> None:
    """Draw a tick mark around ``centre`` (x, y), ``size`` pixels wide.

    Args:
        image: (h, w, 3) uint8, drawn on.
        centre: (2,) x and y, pixels.
        size: Width, pixels.
        colour: Red, green and blue, 0 to 255.
        thickness: Of the line, pixels.
    """
    lines(image, [centre + size * np.array([(-0.5, 0.0), (-0.12, 0.38), (0.55, -0.42)])], colour, thickness)


def cross(image: np.ndarray, centre: np.ndarray, size: float, colour: Colour, thickness: int) -> None:
    """Draw a diagonal cross around ``centre`` (x, y), ``size`` pixels wide.

    Args:
        image: (h, w, 3) uint8, drawn on.
        centre: (2,) x and y, pixels.
        size: Width, pixels.
        colour: Red, green and blue, 0 to 255.
        thickness: Of the lines, pixels.
    """
    half = 0.4 * size
    lines(image, [centre + half * np.array([(-1, s), (1, -s)]) for s in (-1.0, 1.0)], colour, thickness)
