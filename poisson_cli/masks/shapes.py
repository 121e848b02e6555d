"""Shapes drawn on a grid of pixels: a pixel is selected when its centre lies inside."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from poisson_cli.masks.runs import paint
from poisson_cli.masks.scan import polygon_runs
from poisson_cli.settings import Ellipse, Polygon, Rectangle

__all__ = ["draw_ellipse", "draw_polygon", "draw_rectangle"]


def draw_rectangle(rectangle: Rectangle, shape: tuple[int, int]) -> NDArray[np.bool_]:
    """Select a rectangle.

    Parameters
    ----------
    rectangle
        Rows ``row .. row + height - 1`` by columns ``col .. col + width - 1``.
    shape
        (H, W) of the grid; what lies outside is left out.

    Returns
    -------
    ndarray
        (H, W) bool, True = selected.

    Examples
    --------
    >>> draw_rectangle(Rectangle(row=-1, col=1, height=2, width=1), (2, 3)).astype(int).tolist()
    [[0, 1, 0], [0, 0, 0]]
    """
    mask = np.zeros(shape, np.bool_)
    rows = slice(max(rectangle.row, 0), max(rectangle.row + rectangle.height, 0))
    cols = slice(max(rectangle.col, 0), max(rectangle.col + rectangle.width, 0))
    mask[rows, cols] = True
    return mask


def draw_ellipse(ellipse: Ellipse, shape: tuple[int, int]) -> NDArray[np.bool_]:
    """Select an ellipse.

    Parameters
    ----------
    ellipse
        What to select.
    shape
        (H, W) of the grid; what lies outside is left out.

    Returns
    -------
    ndarray
        (H, W) bool, True = selected.

    Examples
    --------
    >>> draw_ellipse(Ellipse(Rectangle(0, 0, 3, 4)), (3, 4)).astype(int).tolist()
    [[0, 1, 1, 0], [1, 1, 1, 1], [0, 1, 1, 0]]
    """
    mask = np.zeros(shape, np.bool_)
    row, col, height, width = ellipse.box
    for line in range(max(row, 0), min(row + height, shape[0])):
        # (x / W)^2 + (y / H)^2 < 1 for the distances from the middle, doubled to make them whole numbers. Exact, as
        # Python's integers are: floats would decide by their rounding next to the edge of a large ellipse.
        y = 2 * (line - row) + 1 - height
        x = math.isqrt((width**2 * (height**2 - y**2) - 1) // height**2)
        first, last = col + (width - x) // 2, col + (width - 1 + x) // 2
        mask[line, max(first, 0) : max(last + 1, 0)] = True
    return mask


def draw_polygon(polygon: Polygon, shape: tuple[int, int]) -> NDArray[np.bool_]:
    """Select what a closed line encloses.

    Parameters
    ----------
    polygon
        What to select.
    shape
        (H, W) of the grid; what lies outside is left out.

    Returns
    -------
    ndarray
        (H, W) bool, True = selected.

    Raises
    ------
    InputError
        If it is too intricate.

    Examples
    --------
    >>> draw_polygon(Polygon(((0, 0), (0, 3), (3, 3))), (3, 4)).astype(int).tolist()
    [[1, 1, 1, 0], [0, 1, 1, 0], [0, 0, 1, 0]]
    """
    runs = polygon_runs([np.array(polygon.points, np.float64)], shape, polygon.rule)
    return paint(*runs, shape[0] * shape[1]).reshape(shape)
