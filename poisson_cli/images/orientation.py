"""Turning pixels upright: the Orientation tag of EXIF and TIFF."""

from __future__ import annotations

from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

__all__ = ["upright"]

_TURNS: Final = {
    # tag: (swap rows and columns, then reverse the rows, then reverse the columns)
    1: (False, False, False),
    2: (False, False, True),
    3: (False, True, True),
    4: (False, True, False),
    5: (True, False, False),
    6: (True, False, True),
    7: (True, True, True),
    8: (True, True, False),
}


def upright(pixels: NDArray[Any], orientation: int) -> NDArray[Any]:
    """Undo an orientation.

    Parameters
    ----------
    pixels
        (H, W) or (H, W, C), as stored.
    orientation
        Value of the tag, 1 to 8: where the stored first row and column belong. Any other value counts as 1, because
        writers leave 0 there when they do not know.

    Returns
    -------
    ndarray
        The pixels as they should be looked at; contiguous.

    Examples
    --------
    >>> upright(np.array([[1, 2, 3]], np.uint8), 8).tolist()
    [[3], [2], [1]]
    """
    swap, reverse_rows, reverse_cols = _TURNS.get(orientation, _TURNS[1])
    if swap:
        pixels = np.swapaxes(pixels, 0, 1)
    if reverse_rows:
        pixels = pixels[::-1]
    if reverse_cols:
        pixels = pixels[:, ::-1]
    return np.ascontiguousarray(pixels)
