"""A selection shown on its picture."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from poisson_cli.masks.growth import grow

__all__ = ["show"]

_LINE: Final = (255, 214, 10)
_DIMMED: Final = 3
"""What is not selected keeps one part in so many of its brightness."""

_LINES_ACROSS: Final = 500
"""The line is as wide as this part of the longer side, to be seen on a large picture as on a small one."""


def show(pixels: NDArray[np.uint8], mask: NDArray[np.bool_]) -> NDArray[np.uint8]:
    """Dim what is not selected, and draw a line round what is; no selected pixel changes.

    Parameters
    ----------
    pixels
        Grey (H, W) or RGB (H, W, 3), uint8.
    mask
        (H, W) bool, True = selected.

    Returns
    -------
    ndarray
        RGB (H, W, 3) uint8.

    Examples
    --------
    >>> show(np.full((1, 4), 90, np.uint8), np.array([[True, False, False, False]]))[0].tolist()
    [[90, 90, 90], [255, 214, 10], [30, 30, 30], [30, 30, 30]]
    """
    colours = pixels if pixels.ndim == 3 else np.repeat(pixels[..., None], 3, axis=2)
    shown = np.where(mask[..., None], colours, colours // _DIMMED)
    width = max(1, round(max(mask.shape) / _LINES_ACROSS))
    shown[grow(mask, width) & ~mask] = _LINE
    return shown
