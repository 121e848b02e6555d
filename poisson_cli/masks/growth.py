"""Growing and shrinking a selection by a Euclidean distance, in a time that does not depend on the distance.

A pixel is at most n away from a selected one if in its row there is a pixel, d rows away from a selected one of its own
column, that is at most sqrt(n^2 - d^2) away. So one pass along the columns finds d, and another along the rows how far
the reach of the pixels so far extends.
"""

from __future__ import annotations

import math
from typing import Final

import numpy as np
from numpy.typing import NDArray

__all__ = ["grow", "shrink"]

_BAND: Final = 1 << 20
"""Pixels that are worked on at once."""


def grow(mask: NDArray[np.bool_], pixels: int) -> NDArray[np.bool_]:
    """Select also what is near.

    Parameters
    ----------
    mask
        (H, W) bool, True = selected.
    pixels
        Pixels whose centre is at most so far from that of a selected one are selected; not negative.

    Returns
    -------
    ndarray
        (H, W) bool, a new array.

    Examples
    --------
    >>> grow(np.array([[True, False, False], [False, False, False]]), 1).astype(int).tolist()
    [[1, 1, 0], [1, 0, 0]]
    """
    height, width = mask.shape
    grown = mask.copy()
    rows, cols = np.flatnonzero(mask.any(axis=1)), np.flatnonzero(mask.any(axis=0))
    if pixels == 0 or rows.size == 0:
        return grown
    near = (
        slice(max(rows[0] - pixels, 0), min(rows[-1] + 1 + pixels, height)),
        slice(max(cols[0] - pixels, 0), min(cols[-1] + 1 + pixels, width)),
    )
    seen = mask[near]
    reach = _reach(seen, pixels)
    band = max(1, _BAND // seen.shape[1])
    here = np.arange(seen.shape[1], dtype=np.int32)
    for first in range(0, seen.shape[0], band):
        by = reach[first : first + band]
        nobody = by < 0
        right = np.maximum.accumulate(np.where(nobody, -1, here + by), axis=1)
        left = np.minimum.accumulate(np.where(nobody, width, here - by)[:, ::-1], axis=1)[:, ::-1]
        grown[near][first : first + band] = (right >= here) | (left <= here)
    return grown


def shrink(mask: NDArray[np.bool_], pixels: int) -> NDArray[np.bool_]:
    """Select no longer what is near to the outside. The edge of the picture is no outside: what reaches it stays there.

    Parameters
    ----------
    mask
        (H, W) bool, True = selected.
    pixels
        Pixels whose centre is at most so far from that of one not selected are left out; not negative.

    Returns
    -------
    ndarray
        (H, W) bool, a new array.

    Examples
    --------
    >>> shrink(np.array([[True, True, True, False]]), 1).astype(int).tolist()
    [[1, 1, 0, 0]]
    """
    return ~grow(~mask, pixels)


def _reach(mask: NDArray[np.bool_], pixels: int) -> NDArray[np.int32]:
    """How many columns far each pixel reaches for the selected ones of its own column; (H, W), -1 = nowhere."""
    height, width = mask.shape
    farthest = min(pixels, height - 1)
    reach_from = np.full(farthest + 2, -1, np.int32)  # by distance in rows; the last one means too far
    for away in range(farthest + 1):
        reach_from[away] = min(math.isqrt(pixels**2 - away**2), width)
    reach = np.empty((height, width), np.int32)
    here = np.arange(height, dtype=np.int32)[:, None]
    too_far = farthest + 1
    band = max(1, _BAND // height)
    for first in range(0, width, band):
        selected = mask[:, first : first + band]
        above = np.maximum.accumulate(np.where(selected, here, -too_far), axis=0)
        below = np.minimum.accumulate(np.where(selected, here, height + too_far)[::-1], axis=0)[::-1]
        away = np.minimum(np.minimum(here - above, below - here), too_far)
        reach[:, first : first + band] = reach_from[away]
    return reach
