"""Runs: selected pixels as half-open intervals of pixel numbers.

A picture's pixels are numbered along its rows (or, in COCO, its columns), each line going on where the one before
ended. Whatever draws many small things draws them as runs, and paints once.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

__all__ = ["paint"]


def paint(starts: NDArray[np.int64], ends: NDArray[np.int64], size: int) -> NDArray[np.bool_]:
    """Select all that lies in some run.

    Parameters
    ----------
    starts, ends
        (n,) int64, ``0 <= starts <= ends <= size``: the runs ``[start, end)``, in any order; they may overlap and be
        empty.
    size
        How many pixels there are.

    Returns
    -------
    ndarray
        (size,) bool.

    Examples
    --------
    >>> paint(np.array([4, 1]), np.array([5, 3]), 6).astype(int).tolist()
    [0, 1, 1, 0, 1, 0]
    """
    if starts.size == 0:
        return np.zeros(size, np.bool_)
    order = np.argsort(starts, kind="stable")
    starts = starts[order]
    reach = np.maximum.accumulate(ends[order])  # how far the runs up to this one go
    apart = starts[1:] > reach[:-1]
    # The union as disjoint intervals, and from their borders the lengths of what lies between and in them, in turn.
    borders = np.empty(2 * (np.count_nonzero(apart) + 1) + 2, np.int64)
    borders[0], borders[-1] = 0, size
    borders[1:-1:2] = starts[np.concatenate(([True], apart))]
    borders[2:-1:2] = reach[np.concatenate((apart, [True]))]
    lengths = np.diff(borders)
    return np.repeat(np.arange(lengths.size) % 2 == 1, lengths)
