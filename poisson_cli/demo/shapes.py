"""What a hand draws on a picture: a loop around something, or a stroke of a brush."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw

__all__ = ["Brush", "Lasso", "Point", "Shape", "draw_mask"]

Point = tuple[float, float]
"""X, Y in pixels, as image viewers show them; whole numbers are centres of pixels."""

Ink = int | tuple[int, int, int]

_STEPS: Final = 8
"""Straight pieces from one point of a lasso to the next: below a pixel of error at the sizes drawn here."""


@dataclass(frozen=True)
class Lasso:
    """A loop drawn by hand; its inside is selected.

    Parameters
    ----------
    points
        Points on the loop in order. The curve runs smoothly through them and back to the first; it may leave the
        picture.
    """

    points: tuple[Point, ...]

    def draw(self, canvas: ImageDraw.ImageDraw, ink: Ink) -> None:
        """Paint the inside, its edge included."""
        canvas.polygon(_closed_curve(self.points), fill=ink)


@dataclass(frozen=True)
class Brush:
    """A stroke of a round brush.

    Parameters
    ----------
    points
        The corners of the stroke.
    width
        Diameter of the brush in pixels.
    """

    points: tuple[Point, ...]
    width: int

    def draw(self, canvas: ImageDraw.ImageDraw, ink: Ink) -> None:
        """Paint the stroke."""
        canvas.line(self.points, fill=ink, width=self.width)
        reach = (self.width - 1) / 2
        for x, y in self.points:  # Pillow leaves notches where two pieces meet
            canvas.ellipse((x - reach, y - reach, x + reach, y + reach), fill=ink)


Shape = Lasso | Brush


def draw_mask(shapes: Sequence[Shape], height: int, width: int) -> NDArray[np.bool_]:
    """Draw a selection.

    Parameters
    ----------
    shapes
        Selected is what any of them covers.
    height, width
        Size of the picture that they were drawn on, in pixels.

    Returns
    -------
    ndarray
        (height, width) bool, True = selected.

    Examples
    --------
    >>> draw_mask([Brush(((1, 0), (1, 2)), width=1)], 3, 3).astype(int).tolist()
    [[0, 1, 0], [0, 1, 0], [0, 1, 0]]
    """
    image = Image.new("L", (width, height))
    canvas = ImageDraw.Draw(image)
    for shape in shapes:
        shape.draw(canvas, 255)
    return np.asarray(image) > 0


def _closed_curve(points: Sequence[Point]) -> list[Point]:
    """A closed Catmull-Rom spline through the points, as a polygon."""
    start = np.asarray(points, np.float64)
    before, end, after = np.roll(start, 1, 0), np.roll(start, -1, 0), np.roll(start, -2, 0)
    t = (np.arange(_STEPS) / _STEPS)[:, None, None]
    curve = start + t / 2 * (
        (end - before)
        + t * (2 * before - 5 * start + 4 * end - after + t * (3 * (start - end) + after - before))
    )
    return [(float(x), float(y)) for x, y in curve.swapaxes(0, 1).reshape(-1, 2)]
