"""Where a value lies in memory: the one description of the layout that every kernel relies on.

A level is a grid of ``height x width`` cells, coloured like a chessboard: cell (row, col) is red (0) when
``row + col`` is even, black (1) when it is odd.  A row is split by colour, so that every colour is contiguous and
a half sweep is a run of plain, vectorisable loops.  Cell ``col`` of a row becomes index ``i = col // 2``::

    the grid              row 0:  r0 b0 r1 b1 r2 b2         row 1:  b0 r0 b1 r1 b2 r2

    in memory   row 0, red   r0 r1 r2 .   row 0, black  b0 b1 b2 .   row 1, red   r0 r1 r2 .   row 1, black ...
                |<-- stride, a multiple of 64 bytes -->|                          '.' = padding, always zero

Which neighbours has cell ``i`` of one colour?  All four are of the other colour:

    north, south   the rows above and below, at the same index ``i``
    the same row   index ``i``, and index ``i - 1`` or ``i + 1``: left where the cell's column is even
                   (``(row + colour) % 2 == 0``), right where it is odd

A row has at least one zero of padding behind it and a level one row of zeros above and below it, so index -1 and
index ``half`` of any row read a zero: no kernel tests for the edge of the grid.  The four children of coarse cell
``X`` in coarse row ``Y`` lie at index ``i = X`` of fine rows ``2Y`` and ``2Y + 1``: aggregation needs no gather.

Fields of several channels interleave them row by row: row 0 of channel 0 (red, black), row 0 of channel 1, ...  All
levels of a field lie in one flat array, the finest first.  `table` holds one line per level, and its columns
are the constants below; a value's position is

    channels * table[level, OFFSET] + ((row + 1) * channels + channel) * 2 * stride + colour * stride + i

Coefficients are shared by all channels: they are fields of one channel.  The finest level's edges all have
conductance 1 and are not stored; the edge fields therefore begin at level 1 (``table[1, OFFSET]`` is subtracted).

Only *runs* are ever visited: the maximal stretches ``[low, high)`` of indices that hold a cell of the region, short
gaps bridged.  Runs of row ``row`` are ``runs[run_start[k] : run_start[k + 1]]`` with ``k = table[level, ROWS] + row``.
"""

import numpy as np
from numpy.typing import NDArray

HEIGHT, WIDTH, HALF, STRIDE, OFFSET, ROWS = range(6)

ALIGNMENT = 64  # bytes: a cache line, and the widest vector register
LANES = ALIGNMENT // 4  # float32 values in it


def layout_table(shapes: list[tuple[int, int]]) -> NDArray[np.int64]:
    """The layout of grids with these shapes.

    Parameters
    ----------
    shapes : list of (height, width)
        Finest first.

    Returns
    -------
    (n_levels + 1, 6) int64
        One line per level; the last line holds the totals: its ``OFFSET`` is the size of a one-channel field, its
        ``ROWS`` the number of rows of all levels.
    """
    table = np.zeros((len(shapes) + 1, 6), np.int64)
    offset = rows = 0
    for level, (height, width) in enumerate(shapes):
        half = (width + 1) // 2
        stride = -(-(half + 1) // LANES) * LANES  # at least one zero behind every row
        table[level] = height, width, half, stride, offset, rows
        # One row of zeros above, one below: two below an odd height, whose last coarse row lacks a child.
        offset += (height + 2 + height % 2) * 2 * stride
        rows += height
    table[-1, OFFSET], table[-1, ROWS] = offset, rows
    return table


def aligned_zeros(size: int) -> NDArray[np.float32]:
    """`size` float32 zeros that begin on a cache line (numpy promises 16 bytes only)."""
    raw = np.zeros(size + LANES, np.float32)
    start = (-raw.ctypes.data % ALIGNMENT) // 4
    return raw[start : start + size]


def field(table: NDArray[np.int64], channels: int, *, levels: int | None = None) -> NDArray[np.float32]:
    """Zeros for one field of `channels` channels, on all levels or on the first `levels` of them."""
    return aligned_zeros(channels * int(table[-1 if levels is None else levels, OFFSET]))
