"""Where a value lies in memory: the one description of the layout that every kernel relies on.

A level is a grid of cells.  It is cut into four *quarters* by the parity of row and column, so that each 2 x 2 block of
cells, which is one cell of the next coarser level, has one cell in every quarter, all at the same place::

    the grid                      quarter 0 (red)     quarter 1 (black)
                                   even row, col        odd column
      a0 b0 a1 b1 a2 b2             a0 a1 a2  .         b0 b1 b2  .
      c0 d0 c1 d1 c2 d2             a3 a4 a5  .         b3 b4 b5  .
      a3 b3 a4 b4 a5 b5           quarter 2 (black)   quarter 3 (red)         '.' = padding, always zero
      c3 d3 c4 d4 c5 d5              odd row            odd row, col
                                    c0 c1 c2  .         d0 d1 d2  .
                                    c3 c4 c5  .         d3 d4 d5  .

Quarters 0 and 3 are the red cells of a chessboard, 1 and 2 the black ones: the four neighbours of a cell lie in two
quarters of the other colour, two of them at its own place and two a step away.  For place t of quarter q

    north, south    quarter q ^ 2, at t - stride and t  (even rows)      or  t and t + stride  (odd rows)
    west, east      quarter q ^ 1, at t - 1 and t       (even columns)   or  t and t + 1       (odd columns)

so that a half sweep is two plain loops without gathers, and aggregation adds four numbers at one place.

A quarter has `rows x cols` places, stored in rows of `stride` values, a multiple of 64 bytes.  Behind each row lies at
least one zero and above and below the quarter a row of zeros: reading beyond an edge reads a zero, and no kernel tests
for edges.  All levels of a field lie in one flat array, the finest first; on a level come the channels, in a channel
the quarters.  `table` holds one line per level, with the columns named below; place (row, col) of a quarter is at

    channels * table[level, OFFSET] + (4 * channel + quarter) * table[level, QUARTER] + (row + 1) * stride + col

Coefficients are shared by all channels: they are fields of one channel.  The finest level's edges all have
conductance 1 and are not stored: the edge fields begin at level 1 (``table[1, OFFSET]`` is subtracted).

Only places of the region are visited.  *Runs* are the stretches of a row of places that hold a cell of the region:
``runs[k] = row, low, high`` for ``k`` in ``range(table[level, FIRST_RUN], table[level + 1, FIRST_RUN])``, by row.
Short gaps are bridged and both ends moved outwards to whole vectors of 16, the first end to an even one, so that the
run's cells on the next level begin with a whole vector too: what they hold beside the region has weight 0.
*Segments* are the same places in terms of the flat index of a quarter, joined over the ends of rows where that is
cheaper, ``start, end, first_run, end_run``: on coarse levels a segment holds many rows, and a sweep is a few long
loops.
"""

import numpy as np
from numpy.typing import NDArray

HEIGHT, WIDTH, ROWS, COLS, STRIDE, QUARTER, OFFSET, FIRST_RUN, FIRST_SEGMENT = range(9)

ALIGNMENT = 64  # bytes: a cache line, and the widest vector register
LANES = ALIGNMENT // 4  # float32 values in it

RED, BLACK = 0, 1  # colours, as on a chessboard

# Where a region is sparse its unknowns are numbered instead, see `solvers.narrow`.  In place of a neighbour's number:
KNOWN, BEYOND = -1, -2  # the pixel is known, the image ends
FOUR = 4  # lanes: an unknown's values in all channels are as many of these as it takes

# What a cell takes of an interpolated correction, in sevenths.  Interpolation puts the zero of a known pixel into the
# middle of a coarse cell, which is further away than it is: beside it the correction comes out too large.
NOTHING, BESIDE_KNOWN, ALL = np.uint8(0), np.uint8(6), np.uint8(7)

Table = NDArray[np.int64]
Float32 = NDArray[np.float32]


def layout_table(shapes: list[tuple[int, int]]) -> Table:
    """The layout of grids with these shapes.

    Parameters
    ----------
    shapes : list of (height, width)
        Finest first.

    Returns
    -------
    (n_levels + 1, 9) int64
        One line per level; the last line closes the columns that count up: its ``OFFSET`` is the size of a
        one-channel field.  ``FIRST_RUN`` and ``FIRST_SEGMENT`` are left at 0.
    """
    lines = []
    offset = 0
    for height, width in shapes:
        rows, cols = (height + 1) // 2, (width + 1) // 2
        stride = whole_vectors(cols + 1)
        quarter = (rows + 2) * stride
        lines.append([height, width, rows, cols, stride, quarter, offset, 0, 0])
        offset += 4 * quarter
    closing = [0] * 9
    closing[OFFSET] = offset
    return np.array([*lines, closing], np.int64)


def whole_vectors(size: int) -> int:
    """`size` rounded up to a multiple of `LANES`."""
    return -(-size // LANES) * LANES


def aligned_zeros(size: int) -> Float32:
    """`size` float32 zeros that begin on a cache line (numpy promises 16 bytes only)."""
    raw = np.zeros(size + LANES, np.float32)
    start = (-raw.ctypes.data % ALIGNMENT) // 4
    return raw[start : start + size]


def field_size(table: Table, channels: int, *, levels: int | None = None) -> int:
    """Length of one field of `channels` channels, on all levels or on the first `levels` of them."""
    return channels * int(table[-1 if levels is None else levels, OFFSET])
