"""Shapes drawn on a grid of pixels."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from poisson_cli.settings import Rectangle

__all__ = ["draw_rectangle"]


def draw_rectangle(mask: NDArray[np.bool_], rectangle: Rectangle) -> None:
    """Select a rectangle; its part outside the grid is ignored.

    Parameters
    ----------
    mask
        (H, W) bool, modified in place: pixels ``row .. row + height - 1`` by ``col .. col + width - 1`` become True.
    rectangle
        What to select.

    Examples
    --------
    >>> mask = np.zeros((2, 3), np.bool_)
    >>> draw_rectangle(mask, Rectangle(row=-1, col=1, height=2, width=1))
    >>> mask.astype(int).tolist()
    [[0, 1, 0], [0, 0, 0]]
    """
    rows = slice(max(rectangle.row, 0), max(rectangle.row + rectangle.height, 0))
    cols = slice(max(rectangle.col, 0), max(rectangle.col + rectangle.width, 0))
    mask[rows, cols] = True
