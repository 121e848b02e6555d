"""Sheets: a scene's pictures side by side, with labels."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw, ImageFilter, ImageFont

__all__ = ["Cell", "draw_sheet"]

_WIDTH: Final = 1200
_MARGIN: Final = 32
_GAP: Final = 24
_HEADER: Final = 80
_LABEL: Final = 68
"""Height kept free under each picture, in pixels."""

_PAPER: Final = (250, 250, 248)
_MAT: Final = (236, 236, 232)
"""Behind a picture that does not fill its place."""

_INK: Final = (24, 26, 30)
_FAINT: Final = (104, 108, 116)
_ACCENT: Final = (0, 98, 204)
"""Marks the result."""

_LINE: Final = (255, 214, 10)
_CASING: Final = (16, 16, 16)
"""Around the line, so that it is seen on bright pictures too."""

_DIMMED: Final = 0.55
"""How bright a picture remains outside the selection."""


@dataclass(frozen=True)
class Cell:
    """One place on a sheet.

    Parameters
    ----------
    label, note
        What stands below, in one line each.
    pixels
        (H, W) or (H, W, 3) uint8.
    mask
        (H, W) bool, True = selected, to be outlined; None for the bare picture.
    result
        Whether this is what the scene is about.
    """

    label: str
    note: str
    pixels: NDArray[np.uint8]
    mask: NDArray[np.bool_] | None = None
    result: bool = False


def draw_sheet(title: str, source: str, cells: Sequence[Cell], columns: int) -> NDArray[np.uint8]:
    """Draw a sheet.

    Parameters
    ----------
    title
        Headline, left.
    source
        Where the idea comes from, right.
    cells
        What to show, row by row. All places have the proportions of the first picture; another is made as large as
        fits.
    columns
        Places in a row.

    Returns
    -------
    ndarray
        (H, W, 3) uint8.
    """
    height, width = cells[0].pixels.shape[:2]
    place_width = (_WIDTH - 2 * _MARGIN - (columns - 1) * _GAP) // columns
    place = (place_width, round(place_width * height / width))
    rows = -(-len(cells) // columns)
    sheet = Image.new("RGB", (_WIDTH, _HEADER + rows * (place[1] + _LABEL) + _MARGIN // 2), _PAPER)
    canvas = ImageDraw.Draw(sheet)
    canvas.text((_MARGIN, _HEADER / 2), title, _INK, _font(32), anchor="lm")
    canvas.text((_WIDTH - _MARGIN, _HEADER / 2), source, _FAINT, _font(18), anchor="rm")
    for number, cell in enumerate(cells):
        row, column = divmod(number, columns)
        left = _MARGIN + column * (place[0] + _GAP)
        top = _HEADER + row * (place[1] + _LABEL)
        sheet.paste(_framed(cell, place), (left, top))
        ink = _ACCENT if cell.result else _INK
        canvas.text((left, top + place[1] + 21), cell.label, ink, _font(21), anchor="lm")
        canvas.text((left, top + place[1] + 44), cell.note, _FAINT, _font(17), anchor="lm")
        if cell.result:
            box = (left - 5, top - 5, left + place[0] + 4, top + place[1] + 4)
            canvas.rectangle(box, outline=_ACCENT, width=3)
    return np.asarray(sheet)


def _font(size: int) -> ImageFont.FreeTypeFont | ImageFont.ImageFont:
    """Pillow's own typeface, the same on every machine."""
    return ImageFont.load_default(size)


def _framed(cell: Cell, place: tuple[int, int]) -> Image.Image:
    """A picture scaled to its place, with its selection."""
    height, width = cell.pixels.shape[:2]
    scale = min(place[0] / width, place[1] / height)
    size = (round(width * scale), round(height * scale))
    picture = Image.fromarray(cell.pixels).convert("RGB").resize(size, Image.Resampling.LANCZOS)
    if cell.mask is not None:
        picture = _with_selection(picture, cell.mask)
    framed = Image.new("RGB", place, _MAT)
    framed.paste(picture, ((place[0] - size[0]) // 2, (place[1] - size[1]) // 2))
    return framed


def _with_selection(picture: Image.Image, mask: NDArray[np.bool_]) -> Image.Image:
    """Dim what is not selected, and draw a line round what is; the line hides nothing of it.

    The line is drawn at twice the picture's size and scaled down, for soft edges. The mask is blurred by less than one
    of its own pixels first: a line drawn by hand has no steps.
    """
    fine = (2 * picture.width, 2 * picture.height)
    inside = Image.fromarray(mask).convert("L").resize(fine, Image.Resampling.BICUBIC)
    inside = inside.filter(ImageFilter.GaussianBlur(0.8 * fine[0] / mask.shape[1]))
    inside = inside.point([0] * 128 + [255] * 128)
    black = Image.new("RGB", picture.size)
    picture = Image.composite(picture, Image.blend(black, picture, _DIMMED), inside.resize(picture.size))
    for reach, colour in ((7, _CASING), (5, _LINE)):
        line = Image.fromarray(_surround(inside, reach)).resize(picture.size, Image.Resampling.BOX)
        picture = Image.composite(Image.new("RGB", picture.size, colour), picture, line)
    return picture


def _surround(inside: Image.Image, reach: int) -> NDArray[np.uint8]:
    """The pixels outside a shape, but not further than so many pixels; (H, W) uint8, 255 = on the line."""
    grown = (
        np.asarray(inside.filter(ImageFilter.BoxBlur(reach))) > 0
    )  # the mean of a box that meets the shape
    return np.where(grown & (np.asarray(inside) == 0), np.uint8(255), np.uint8(0))
