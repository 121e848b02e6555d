"""Polygons on the grid of pixels.

The rule is COCO's: a pixel is in when its centre is, and areas are half-open, so that what two polygons share is in one
of them exactly. It is written out here because no library in the core keeps it: Pillow's polygons include their edges
and take the corners for centres of pixels, which makes a square of ten pixels 121 pixels large.

A ray from a centre to the left crosses the edges that make it lie inside. So each edge is cut with the centre line of
each row that it passes; in between two cuts a row is all inside or all outside.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final, Literal

import numpy as np
from numpy.typing import NDArray

from poisson_cli.errors import InputError

__all__ = ["MOST_CUTS", "polygon_runs"]

MOST_CUTS: Final = 1 << 22
"""Cuts of edges with rows; more than any drawing has, and few enough for a second and half a gigabyte."""


def polygon_runs(
    polygons: Sequence[NDArray[np.float64]],
    shape: tuple[int, int],
    rule: Literal["even-odd", "nonzero"] = "even-odd",
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Find the runs of pixels inside polygons, each polygon by itself.

    Parameters
    ----------
    polygons
        For each polygon (n, 2) float64: (row, column) of its corners, the last joined to the first, finite.
        See `poisson_cli.settings.Polygon` for what the numbers mean.
    shape
        (H, W) of the grid; what lies outside is left out.
    rule
        See `poisson_cli.settings.Polygon`.

    Returns
    -------
    starts, ends : ndarray
        (m,) int64, for `paint`; pixels are numbered along rows.

    Raises
    ------
    InputError
        If there are more than `MOST_CUTS` cuts.
    """
    height, width = shape
    if not polygons:
        return np.zeros(0, np.int64), np.zeros(0, np.int64)
    upper, lower, winding, owner = _edges(polygons)
    # An edge passes the rows whose centre line is at its upper end or below, and above its lower end.
    first = np.clip(np.ceil(upper[:, 0] - 0.5), 0, height).astype(np.int64)
    passed = np.clip(np.ceil(lower[:, 0] - 0.5), 0, height).astype(np.int64) - first
    cuts = int(passed.sum())
    if cuts > MOST_CUTS:
        raise InputError(
            f"the polygons are too intricate: their edges pass {cuts:,} rows, more than {MOST_CUTS:,}; simplify them"
        )
    edge = np.repeat(np.arange(passed.size), passed)
    row = np.arange(cuts) - np.repeat(np.cumsum(passed) - passed - first, passed)
    # From the upper end always: neighbours that share an edge, drawn in opposite directions, share its cuts too.
    (top, left), (down, across) = upper[edge].T, (lower - upper)[edge].T
    cut = left + (row + 0.5 - top) * across / down
    col = np.clip(np.ceil(cut - 0.5), 0, width).astype(
        np.int64
    )  # the first whose centre is not left of the cut

    # In order along the rows of each polygon. A row has one more column here, for what ends at the right edge.
    place = (owner[edge] * height + row) * (width + 1) + col
    order = np.argsort(place, kind="stable")
    place = place[order]
    # A closed line passes each row as often down as up, so the count is back at nothing after each row.
    turns = np.cumsum(winding[edge][order]) if rule == "nonzero" else np.arange(1, cuts + 1) % 2
    inside = turns != 0
    before = np.concatenate(([False], inside[:-1]))
    row, col = np.divmod(place, width + 1)
    pixel = row % height * width + col
    return pixel[inside & ~before], pixel[before & ~inside]


def _edges(
    polygons: Sequence[NDArray[np.float64]],
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.int64], NDArray[np.int64]]:
    """Upper and lower end of every edge, each (n, 2); +1 if it was drawn downwards, else -1; and whose it is."""
    corners = np.array([len(points) for points in polygons])
    head = np.concatenate(polygons)
    last = np.cumsum(corners) - 1
    following = np.arange(1, len(head) + 1)
    following[last] = last - corners + 1
    tail = head[following]
    downwards = head[:, 0] <= tail[:, 0]
    upper = np.where(downwards[:, None], head, tail)
    lower = np.where(downwards[:, None], tail, head)
    return upper, lower, np.where(downwards, 1, -1), np.repeat(np.arange(len(polygons)), corners)
