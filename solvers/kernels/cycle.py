"""The steps of a cycle: relaxation, restriction, interpolation, exact solution.

The finest level knows that all its conductances are 1.  Operations take ranges of segments, so that a caller can give
bands to several threads or return to Python in between; a half sweep reads only the other colour, hence any split, and
any order in which neighbours come before what reads them, gives the same bits.  There are two ways through a level: a
wave of segments, all channels together, for any level and any range (`sweep`), and row by row, channel by channel, for
the whole of a finest level whose rows are long (`sweep_in_rows`).
"""

import numpy as np

from solvers.kernels.policy import inlined, jit, loops
from solvers.layout import (
    ALL,
    BLACK,
    COLS,
    FIRST_RUN,
    FIRST_SEGMENT,
    LANES,
    OFFSET,
    QUARTER,
    RED,
    ROWS,
    STRIDE,
)

# What a step is.  A sweep from zero takes x for zero, whatever it holds; a turn ends one cycle and begins the next.
SWEEP, SWEEP_FROM_ZERO, TURN, COARSEST = 0, 1, 2, 3
KIND, LEVEL, CYCLE = 0, 1, 2  # columns of steps,
PROLONG, RED_AFTER, BLACK_AFTER, RED_BEFORE, BLACK_BEFORE, RESTRICT = (
    3,
    5,
    7,
    9,
    11,
    13,
)  # where ranges begin,
COLUMNS = 15  # and how many there are
WHOLE = -1  # as the end of a range: all segments of the level

# Interpolation makes the coarse correction this much larger: piecewise constant restriction leaves it a few percent too
# small for smooth errors.  Beside known pixels it is too large, see `layout.BESIDE_KNOWN`.
OVERCORRECTION = 1.0375
NEAR, FAR = np.float32(0.75 * OVERCORRECTION), np.float32(0.25 * OVERCORRECTION)
NEAR_PER_SHARE, FAR_PER_SHARE = np.float32(0.75 / int(ALL)), np.float32(0.25 / int(ALL))

# The black half sweep after a coarse correction goes this much too far, on the finest level and where another sweep
# follows.  The three were searched for together on the regions of ``python -m benchmarks convergence``.  Without any of
# them F-cycles contract by 0.10 on a disk; without BESIDE_KNOWN by 0.08, and by 0.17 where one corner alone is known;
# with all of them by 0.07 and 0.13.
OVERRELAXATION = np.float32(1.7)

u = np.uint64  # what arrays are indexed with, see solvers.kernels

ABS_BITS = np.int32(0x7FFFFFFF)  # all but the sign of a float32
FAR_OFF = np.int64(1) << 62  # beyond any place


@inlined
def bits_of(value):
    """The bit pattern of |value|: as integers these order like the values, with NaN on top."""
    return np.int32(np.float32(value).view(np.int32) & ABS_BITS)


@inlined
def largest_of(a, b):
    """The larger one of two bit patterns; `max` would make 64-bit integers of them."""
    return a if a > b else b


# --- places and coefficients -------------------------------------------------------------------------------------
#
# Both quarters of a colour are gone through together: they have the same neighbours, half of which lie at their own
# place, and are read once for the two of them.  Of that colour `upper` is the quarter in the even rows, `lower` that in
# the odd rows; of the other colour `along` lies in the rows of upper, `under` in the rows of lower:
#
#     red:      upper  along      black:      along  upper
#               under  lower                  lower  under
#
# At a place t, upper's neighbours are along and under at t, `north` = under a row before, and `side` = along a column
# before (red) or behind (black); lower's are the same two at t, `south` = along a row behind, and `flank` = under a
# column behind (red) or before (black).
#
# So are the three channels of a colour picture on coarse levels, where half of all that is read are coefficients: they
# are read once for the three of them.


@inlined
def quarters(size, colour, at):
    """Where a place lies in upper and lower of a field that begins there."""
    return u(colour * size + at), u((3 - colour) * size + at)


@inlined
def places(size, stride, colour, at):
    """Where it lies in upper, lower, along and under, and where north, south, side and flank are."""
    upper, lower = quarters(size, colour, at)
    along, under = u((colour ^ 1) * size + at), u((colour ^ 2) * size + at)
    north, south = under - u(stride), along + u(stride)
    side = along - u(1) if colour == RED else along + u(1)
    flank = under + u(1) if colour == RED else under - u(1)
    return upper, lower, along, under, north, south, side, flank


@inlined
def edges(colour, at):
    """Where upper's conductances lie, to north (in edge_s), side and along (in edge_e), and lower's, to flank and under
    (in edge_e), for `places` of an edge field.

    Upper's to under, lower's to along and lower's to south are what edge_s holds at upper, along and lower.
    """
    upper, lower, along, under, north, _, side, flank = at
    if colour == RED:
        return north, side, upper, lower, under
    return north, upper, along, flank, lower


@loops
def coefficients(centre, edge_e, edge_s, i, own, at, to):
    """Of upper and lower: the weights or diagonals, and the conductances to north, under, side, along and along, south,
    flank, under.

    centre: weight or diagonal, `own` its `quarters`.  at: `places` of the edge fields.  to: from `edges`.
    """
    upper, lower, along = at[0], at[1], at[2]
    north, side, to_along, flank, under = to
    return (
        centre[own[0] + i], centre[own[1] + i],
        edge_s[north + i], edge_s[upper + i], edge_e[side + i], edge_e[to_along + i],
        edge_s[along + i], edge_s[lower + i], edge_e[flank + i], edge_e[under + i],
    )  # fmt: skip


# --- relaxation --------------------------------------------------------------------------------------------------


@loops
def relax_red(x, b, weight, size, stride, channels, at, n):
    """Gauss-Seidel on n places of the red quarters of the finest level, from `at` on."""
    w_upper, w_lower = quarters(size, RED, at)
    for channel in range(channels):
        here = 4 * channel * size + at
        upper, lower, along, under, north, south, side, flank = places(size, stride, RED, here)
        for i in range(u(n)):
            shared = x[along + i] + x[under + i]
            x[upper + i] = weight[w_upper + i] * (b[upper + i] + (x[north + i] + x[side + i]) + shared)
            x[lower + i] = weight[w_lower + i] * (b[lower + i] + (x[south + i] + x[flank + i]) + shared)


@loops
def relax_finest(x, b, weight, size, stride, channels, colour, at, n, omega):
    """The same for any colour, over-relaxed by `omega` (float32).  Returns the bit pattern of the largest change."""
    w_upper, w_lower = quarters(size, colour, at)
    largest = np.int32(0)
    for channel in range(channels):
        here = 4 * channel * size + at
        upper, lower, along, under, north, south, side, flank = places(size, stride, colour, here)
        for i in range(u(n)):
            shared = x[along + i] + x[under + i]
            new_upper = weight[w_upper + i] * (b[upper + i] + (x[north + i] + x[side + i]) + shared)
            new_lower = weight[w_lower + i] * (b[lower + i] + (x[south + i] + x[flank + i]) + shared)
            change_upper, change_lower = (
                omega * (new_upper - x[upper + i]),
                omega * (new_lower - x[lower + i]),
            )
            largest = largest_of(largest, largest_of(bits_of(change_upper), bits_of(change_lower)))
            x[upper + i] += change_upper
            x[lower + i] += change_lower
    return largest


@loops
def relaxed(x, b, at, i, c):
    """What Gauss-Seidel makes of a place of upper and of lower of a coarse level; c: `coefficients` with weights."""
    upper, lower, along, under, north, south, side, flank = at
    w_upper, w_lower, to_north, to_under, to_side, to_along, from_along, to_south, to_flank, from_under = c
    new_upper = (b[upper + i] + to_north * x[north + i] + to_under * x[under + i]) + (
        to_side * x[side + i] + to_along * x[along + i]
    )
    new_lower = (b[lower + i] + from_along * x[along + i] + to_south * x[south + i]) + (
        to_flank * x[flank + i] + from_under * x[under + i]
    )
    return w_upper * new_upper, w_lower * new_lower


@loops
def relax_coarse_places(x, b, at, i, c, omega):
    """Puts it there, over-relaxed by `omega`: by 1 means that what was there may be anything."""
    upper, lower = at[0], at[1]
    new_upper, new_lower = relaxed(x, b, at, i, c)
    if omega == np.float32(1.0):
        x[upper + i], x[lower + i] = new_upper, new_lower
    else:
        x[upper + i] += omega * (new_upper - x[upper + i])
        x[lower + i] += omega * (new_lower - x[lower + i])


@loops
def relax_coarse(x, b, weight, edge_e, edge_s, size, stride, channels, offset, skip, colour, at, n, omega):
    """Relaxation on a coarse level, whose coefficients begin at `offset`, and at `skip` less in the edge fields."""
    w, e = quarters(size, colour, offset + at), places(size, stride, colour, offset - skip + at)
    to, own = edges(colour, e), places(size, stride, colour, channels * offset + at)
    if channels == 3:
        second, third = u(4 * size), u(8 * size)
        for i in range(u(n)):
            c = coefficients(weight, edge_e, edge_s, i, w, e, to)
            relax_coarse_places(x, b, own, i, c, omega)
            relax_coarse_places(x, b, own, second + i, c, omega)
            relax_coarse_places(x, b, own, third + i, c, omega)
        return
    for channel in range(channels):
        first = u(4 * channel * size)
        for i in range(u(n)):
            c = coefficients(weight, edge_e, edge_s, i, w, e, to)
            relax_coarse_places(x, b, own, first + i, c, omega)


@jit
def relax_over(x, b, weight, segments, table, channels, colour, omega, first, end):
    """Half sweep of over-relaxation by `omega` (float32) over segments [first, end) of the finest level."""
    stride, size = table[0, STRIDE], table[0, QUARTER]
    for k in range(first, end):
        at, n = segments[k, 0], segments[k, 1] - segments[k, 0]
        relax_finest(x, b, weight, size, stride, channels, colour, at, n, omega)


@loops
def relax_segment_from_zero(x, b, weight, segments, table, level, channels, k):
    """Gauss-Seidel on the red quarters of a level whose x counts as zero, whatever it holds."""
    size, offset = table[level, QUARTER], table[level, OFFSET]
    for quarter in (RED, 3 - RED):
        for channel in range(channels):
            here = quarter * size + segments[k, 0]
            own, w = u(channels * offset + 4 * channel * size + here), u(offset + here)
            for i in range(u(segments[k, 1] - segments[k, 0])):
                x[own + i] = weight[w + i] * b[own + i]


@inlined
def relax_segment(x, b, weight, edge_e, edge_s, segments, table, level, channels, colour, k, omega):
    """Relaxation of the two quarters of one colour; returns the largest change of black cells on the finest level."""
    stride, size, offset = table[level, STRIDE], table[level, QUARTER], table[level, OFFSET]
    at, n = segments[k, 0], segments[k, 1] - segments[k, 0]
    if level > 0:
        skip = table[1, OFFSET]
        relax_coarse(x, b, weight, edge_e, edge_s, size, stride, channels, offset, skip, colour, at, n, omega)
    elif colour == RED:
        relax_red(x, b, weight, size, stride, channels, at, n)
    else:
        return relax_finest(x, b, weight, size, stride, channels, BLACK, at, n, omega)
    return np.int32(0)


# --- restriction -------------------------------------------------------------------------------------------------


@loops
def residuals_coarse(x, b, at, i, c):
    """The sum of the residuals in a place of upper and of lower of a coarse level; c: `coefficients` with diagonals."""
    upper, lower, along, under, north, south, side, flank = at
    d_upper, d_lower, to_north, to_under, to_side, to_along, from_along, to_south, to_flank, from_under = c
    nothing = np.float32(0.0)
    r_upper = (
        (b[upper + i] - d_upper * x[upper + i])
        + (to_north * x[north + i] + to_under * x[under + i])
        + (to_side * x[side + i] + to_along * x[along + i])
    )
    r_lower = (
        (b[lower + i] - d_lower * x[lower + i])
        + (from_along * x[along + i] + to_south * x[south + i])
        + (to_flank * x[flank + i] + from_under * x[under + i])
    )
    return (r_upper if d_upper > nothing else nothing) + (r_lower if d_lower > nothing else nothing)


@loops
def find_residuals_finest(scratch, x, b, diagonal, size, stride, channels, at, n):
    """scratch[channel * n : ] = residuals in n places of the red quarters, two for each cell of the next level."""
    d_upper, d_lower = quarters(size, RED, at)
    nothing = np.float32(0.0)
    for channel in range(channels):
        here, to = 4 * channel * size + at, u(channel * n)
        upper, lower, along, under, north, south, side, flank = places(size, stride, RED, here)
        for i in range(u(n)):  # outside the region b means nothing
            shared = x[along + i] + x[under + i]
            around_upper = b[upper + i] + (x[north + i] + x[side + i]) + shared
            around_lower = b[lower + i] + (x[south + i] + x[flank + i]) + shared
            r_upper = around_upper - diagonal[d_upper + i] * x[upper + i]
            r_lower = around_lower - diagonal[d_lower + i] * x[lower + i]
            r_upper = r_upper if diagonal[d_upper + i] > nothing else nothing
            r_lower = r_lower if diagonal[d_lower + i] > nothing else nothing
            scratch[to + i] = r_upper + r_lower


@loops
def find_residuals_coarse(
    scratch, x, b, diagonal, edge_e, edge_s, size, stride, channels, offset, skip, at, n
):
    """The same on a coarse level."""
    d, e = quarters(size, RED, offset + at), places(size, stride, RED, offset - skip + at)
    to, own = edges(RED, e), places(size, stride, RED, channels * offset + at)
    if channels == 3:
        second, third, to_second, to_third = u(4 * size), u(8 * size), u(n), u(2 * n)
        for i in range(u(n)):
            c = coefficients(diagonal, edge_e, edge_s, i, d, e, to)
            scratch[i] = residuals_coarse(x, b, own, i, c)
            scratch[to_second + i] = residuals_coarse(x, b, own, second + i, c)
            scratch[to_third + i] = residuals_coarse(x, b, own, third + i, c)
        return
    for channel in range(channels):
        first, here = u(4 * channel * size), u(channel * n)
        for i in range(u(n)):
            c = coefficients(diagonal, edge_e, edge_s, i, d, e, to)
            scratch[here + i] = residuals_coarse(x, b, own, first + i, c)


@inlined
def whole_vectors(n):
    """n rounded up to whole vectors.  What that adds behind a run lies on the same row, and outside the region."""
    return u((n + LANES - 1) & -LANES)


@loops
def hand_down(b, scratch, start, n, at, size):
    """n sums of residuals from scratch[start] on become right-hand sides of level + 1; even columns go to `at`."""
    even, odd, first, half = u(at), u(at + size), u(start), whole_vectors(n // 2)
    for i in range(half):  # both in one loop: LLVM then loads whole vectors and takes them apart
        b[even + i] = scratch[first + i + i]
        b[odd + i] = scratch[first + i + i + u(1)]


@inlined
def restrict_segment(b, x, diagonal, edge_e, edge_s, scratch, runs, segments, table, level, channels, k):
    """Right-hand side of level + 1 below a segment: each cell the sum of its children's residuals.

    A black half sweep must have come before: black residuals are then zero, and only the red ones are computed.
    """
    stride, size, offset = table[level, STRIDE], table[level, QUARTER], table[level, OFFSET]
    at = segments[k, 0]
    n = segments[k, 1] - at
    if level == 0:
        find_residuals_finest(scratch, x, b, diagonal, size, stride, channels, at, n)
    else:
        skip = table[1, OFFSET]
        find_residuals_coarse(
            scratch, x, b, diagonal, edge_e, edge_s, size, stride, channels, offset, skip, at, n
        )
    coarse_size = table[level + 1, QUARTER]
    for channel in range(channels):
        plane = channels * table[level + 1, OFFSET] + 4 * channel * coarse_size
        for run in range(segments[k, 2], segments[k, 3]):
            row, low = np.int64(runs[run, 0]), np.int64(runs[run, 1])
            to = plane + 2 * (row & 1) * coarse_size + (row // 2 + 1) * table[level + 1, STRIDE] + low // 2
            start = channel * n + (row + 1) * stride + low - at
            hand_down(b, scratch, start, np.int64(runs[run, 2]) - low, to, coarse_size)


# --- interpolation -----------------------------------------------------------------------------------------------


@loops
def blend_run(scratch, x, table, level, channels, channel, row, low, high, at, to):
    """scratch[at : ] = the cells of level + 1 in columns low ... high, blended with the row above them, 3 to 1; and
    scratch[to : ] = the cells in columns low - 1 ... high - 1, blended with the row below.

    An inactive cell counts as 0, and the grid continues with its edge.
    """
    rows, cols = table[level, ROWS], table[level, COLS]
    stride, size = table[level + 1, STRIDE], table[level + 1, QUARTER]
    row_above, row_below = max(row - 1, 0), min(row + 1, rows - 1)
    plane = channels * table[level + 1, OFFSET] + 4 * channel * size + low // 2
    even = u(plane + 2 * (row & 1) * size + (row // 2 + 1) * stride)
    above = u(plane + 2 * (row_above & 1) * size + (row_above // 2 + 1) * stride)
    below = u(plane + 2 * (row_below & 1) * size + (row_below // 2 + 1) * stride)
    odd, above_odd, below_odd = even + u(size), above + u(size), below + u(size)
    one, two, half = u(at), u(to + 1), u((high - low) // 2)
    for i in range(whole_vectors((high - low) // 2)):
        own, own_odd = NEAR * x[even + i], NEAR * x[odd + i]
        scratch[one + i + i] = own + FAR * x[above + i]
        scratch[one + i + i + u(1)] = own_odd + FAR * x[above_odd + i]
        scratch[two + i + i] = own + FAR * x[below + i]
        scratch[two + i + i + u(1)] = own_odd + FAR * x[below_odd + i]
    if high < cols:
        scratch[one + half + half] = NEAR * x[even + half] + FAR * x[above + half]
    else:
        scratch[at + cols - low] = scratch[at + cols - low - 1]
    if low > 0:
        scratch[to] = NEAR * x[odd - u(1)] + FAR * x[below_odd - u(1)]
    else:
        scratch[to] = scratch[to + 1]


@loops
def add_interpolated(x, share, scratch, w, own, size, n, other):
    """x += the share of what lies in scratch, interpolated along the row, in n places of the black quarters; the one in
    the even rows lies from x[own] and share[w] on and finds its cells in scratch, the other one from `other` on.
    """
    near, far = NEAR_PER_SHARE, FAR_PER_SHARE
    largest = np.int32(0)
    upper, w_upper, west = u(own), u(w), u(other)
    lower, w_lower, east = u(own + size), u(w + size), u(1)
    for i in range(u(n)):
        up = np.float32(share[w_upper + i]) * (near * scratch[i] + far * scratch[east + i])
        low = np.float32(share[w_lower + i]) * (near * scratch[west + u(1) + i] + far * scratch[west + i])
        largest = largest_of(largest, largest_of(bits_of(up), bits_of(low)))
        x[upper + i] += up
        x[lower + i] += low
    return largest


@inlined
def prolong_segment(x, share, scratch, runs, segments, table, level, channels, channel, k):
    """Adds the 9-3-3-1 interpolation of level + 1 to the black cells of a segment.

    Only black ones: the next half sweep overwrites the red ones without reading them.  Returns the bit pattern of the
    largest absolute change.

    Quarter 1 holds the upper right children of the cells of level + 1: they lean to the row above and to the next
    column.  Quarter 2 holds the lower left ones: they lean to the row below and to the column before.
    """
    stride, size, offset = table[level, STRIDE], table[level, QUARTER], table[level, OFFSET]
    at, n = segments[k, 0], segments[k, 1] - segments[k, 0]
    other = n + 3 * LANES - 1  # the first half ends with a column more, in whole vectors
    for run in range(segments[k, 2], segments[k, 3]):
        row, low, high = np.int64(runs[run, 0]), np.int64(runs[run, 1]), np.int64(runs[run, 2])
        to = (row + 1) * stride + low - at
        blend_run(scratch, x, table, level, channels, channel, row, low, high, to, other + to)
    return add_interpolated(
        x,
        share,
        scratch,
        offset + size + at,
        channels * offset + (4 * channel + 1) * size + at,
        size,
        n,
        other,
    )


# --- the finest level row by row ---------------------------------------------------------------------------------

LAG = 3  # rows from the first half sweep of a turn to the last one; from that of a sweep it is 1

# Where that is done: rows from their first to their last run may hold so many times the places of all segments,
MORE_PLACES = 1.15
# and a row has so many at least.
SHORTEST_ROW = 24


@loops
def relax_rows(x, b, weight, size, stride, at, n, omega, again):
    """A sweep on the finest level in one loop, on n places from `at` on and those a row before them: the red cells, and
    the black ones a row before, over-relaxed by `omega`.  Unless `again` is None another one follows behind, two and
    three rows before, which is not over-relaxed.

    Each half sweep lies as far behind the one before it as its neighbours reach, and takes what was just computed as it
    is.  Of four accesses to memory three find their row in the first-level cache; half sweeps of their own find none.
    Returns what `relax_finest` does, of both sweeps.

    `x1_2` is quarter 1 two rows before, and so on.
    """
    row = u(stride)
    x0, x1, x2, x3 = u(at), u(at + size), u(at + 2 * size), u(at + 3 * size)
    x0_1, x1_1, x2_1, x3_1 = x0 - row, x1 - row, x2 - row, x3 - row
    x0_2, x1_2, x2_2, x3_2 = x0_1 - row, x1_1 - row, x2_1 - row, x3_1 - row
    x0_3, x1_3, x2_3, x3_3 = x0_2 - row, x1_2 - row, x2_2 - row, x3_2 - row
    south, north = x1 + row, x3_3 - row
    x1_west, x3_1_west, x1_2_west, x3_3_west = x1 - u(1), x3_1 - u(1), x1_2 - u(1), x3_3 - u(1)
    x2_east, x0_1_east, x2_2_east, x0_3_east = x2 + u(1), x0_1 + u(1), x2_2 + u(1), x0_3 + u(1)
    first = second = np.int32(0)
    for i in range(u(n)):
        old_1, old_2 = x[x1_1 + i], x[x2_1 + i]
        shared = x[x1 + i] + x[x2 + i]
        red_0 = weight[x0 + i] * (b[x0 + i] + (old_2 + x[x1_west + i]) + shared)
        red_3 = weight[x3 + i] * (b[x3 + i] + (x[south + i] + x[x2_east + i]) + shared)

        shared = x[x0_1 + i] + x[x3_1 + i]
        black_1 = weight[x1_1 + i] * (b[x1_1 + i] + (x[x3_2 + i] + x[x0_1_east + i]) + shared)
        black_2 = weight[x2_1 + i] * (b[x2_1 + i] + (red_0 + x[x3_1_west + i]) + shared)
        change_1, change_2 = omega * (black_1 - old_1), omega * (black_2 - old_2)
        first = largest_of(first, largest_of(bits_of(change_1), bits_of(change_2)))
        black_1, black_2 = old_1 + change_1, old_2 + change_2

        if again is not None:
            old_1, old_2 = x[x1_3 + i], x[x2_3 + i]
            shared = x[x1_2 + i] + x[x2_2 + i]
            again_0 = weight[x0_2 + i] * (b[x0_2 + i] + (old_2 + x[x1_2_west + i]) + shared)
            again_3 = weight[x3_2 + i] * (b[x3_2 + i] + (black_1 + x[x2_2_east + i]) + shared)

            shared = x[x0_3 + i] + x[x3_3 + i]
            again_1 = weight[x1_3 + i] * (b[x1_3 + i] + (x[north + i] + x[x0_3_east + i]) + shared)
            again_2 = weight[x2_3 + i] * (b[x2_3 + i] + (again_0 + x[x3_3_west + i]) + shared)
            change_1, change_2 = again_1 - old_1, again_2 - old_2
            second = largest_of(second, largest_of(bits_of(change_1), bits_of(change_2)))
            x[x0_2 + i], x[x3_2 + i] = again_0, again_3
            x[x1_3 + i], x[x2_3 + i] = old_1 + change_1, old_2 + change_2

        x[x0 + i], x[x3 + i] = red_0, red_3
        x[x1_1 + i], x[x2_1 + i] = black_1, black_2
    return first, second


@inlined
def row_of_runs(runs, k, end, row):
    """The first column and the end of runs k ... in a row, as far as they lie in it, and the run behind them."""
    low, high = np.int64(0), np.int64(0)
    if k < end and runs[k, 0] == row:
        low = np.int64(runs[k, 1])
    while k < end and runs[k, 0] == row:
        high = np.int64(runs[k, 2])
        k += 1
    return low, high, k


@inlined
def together(one, other):
    """Columns from the first one of two stretches to the end of both; one that ends at 0 is none."""
    if one[1] == 0 or other[1] == 0:
        return other if one[1] == 0 else one
    return min(one[0], other[0]), max(one[1], other[1])


@jit
def rows_pay(runs, segments, table):
    """Whether the finest level is better gone through by `sweep_in_rows` than by `sweep`."""
    end, visited, places = table[1, FIRST_RUN], np.int64(0), np.int64(0)
    if end == 0:
        return False
    for segment in range(table[1, FIRST_SEGMENT]):
        places += segments[segment, 1] - segments[segment, 0]
    k = np.int64(0)
    while k < end:
        low, high, k = row_of_runs(runs, k, end, runs[k, 0])
        visited += high - low
    rows = np.int64(runs[end - 1, 0]) + 1 - runs[0, 0]
    return SHORTEST_ROW * rows <= visited <= MORE_PLACES * places


@inlined
def relax_row(x, b, weight, size, stride, colour, row, columns, omega):
    """A half sweep over some columns of a row; returns the bit pattern of the largest change of black cells."""
    at, n = (row + 1) * stride + columns[0], columns[1] - columns[0]
    if colour == BLACK:
        return relax_finest(x, b, weight, size, stride, 1, BLACK, at, n, omega)
    relax_red(x, b, weight, size, stride, 1, at, n)
    return np.int32(0)


@jit
def sweep_in_rows(x, b, weight, diagonal, share, scratch, runs, table, channels, begins, ends):
    """A visit to the finest level, the same bits as `sweep` makes of it: channel by channel, row by row.

    begins: a cycle begins, with a sweep and restriction.  ends: one ends, with interpolation and an over-relaxed sweep.
    Each row is interpolated into, relaxed by `relax_rows` and handed down as soon as can be.  The rows that are under
    way, at most seven of one channel, stay in the first-level cache, where a wave of segments is kept in the second
    one.  Returns what `sweep` does.
    """
    stride, size, coarse_size = table[0, STRIDE], table[0, QUARTER], table[1, QUARTER]
    end, one = table[1, FIRST_RUN], np.float32(1.0)
    first, last = np.int64(runs[0, 0]), np.int64(runs[end - 1, 0])
    turns, omega = begins and ends, OVERRELAXATION if ends else one
    lag = LAG if turns else 1
    corrected = by_first = by_second = np.int32(0)
    for channel in range(channels):
        plane = 4 * channel * size
        own, right = x[plane : plane + 4 * size], b[plane : plane + 4 * size]
        up = next_ = down = np.int64(0)  # the next run for interpolation, relaxation, restriction
        row_1 = row_2 = row_3 = (np.int64(0), np.int64(0))  # columns of the rows before
        for row in range(first, last + lag + 2):
            # Relaxation reads the row behind it, and at first its own.
            while ends and up < end and runs[up, 0] <= row + 1:
                up_row, low, high = np.int64(runs[up, 0]), np.int64(runs[up, 1]), np.int64(runs[up, 2])
                at, n = (up_row + 1) * stride + low, high - low
                other = n + 3 * LANES - 1
                blend_run(scratch, x, table, 0, channels, channel, up_row, low, high, 0, other)
                change = add_interpolated(x, share, scratch, size + at, plane + size + at, size, n, other)
                corrected = largest_of(corrected, change)
                up += 1
            low, high, next_ = row_of_runs(runs, next_, end, row)
            row_0 = (low, high)
            change = later = np.int32(0)
            if first + lag <= row <= last:
                low, high = together(row_0, row_1)
                if turns:
                    low, high = together((low, high), together(row_2, row_3))
                    at = (row + 1) * stride + low
                    change, later = relax_rows(own, right, weight, size, stride, at, high - low, omega, turns)
                else:
                    at = (row + 1) * stride + low
                    change, later = relax_rows(own, right, weight, size, stride, at, high - low, omega, None)
            else:
                rows = row_0, row_1, row_2, row_3
                for k in range(lag + 1):
                    bits = relax_row(
                        own, right, weight, size, stride, k & 1, row - k, rows[k], omega if k == 1 else one
                    )
                    change, later = bits if k == 1 else change, bits if k == 3 else later
            by_first, by_second = largest_of(by_first, change), largest_of(by_second, later)
            row_1, row_2, row_3 = row_0, row_1, row_2
            # The row before the last one that is done: it reads the row behind it.
            done = row - lag - 1
            while begins and down < end and runs[down, 0] == done:
                low, n = np.int64(runs[down, 1]), np.int64(runs[down, 2]) - runs[down, 1]
                at = (done + 1) * stride + low
                find_residuals_finest(scratch, own, right, diagonal, size, stride, 1, at, n)
                to = channels * table[1, OFFSET] + 4 * channel * coarse_size + 2 * (done & 1) * coarse_size
                hand_down(b, scratch, 0, n, to + (done // 2 + 1) * table[1, STRIDE] + low // 2, coarse_size)
                down += 1
    if not ends:  # the only sweep is one before
        return corrected, by_second, by_first
    return corrected, by_first, by_second


# --- one visit to a level ----------------------------------------------------------------------------------------


@inlined
def range_of(steps, step, operation, table):
    """First and end segment of an operation."""
    first, end = steps[step, operation], steps[step, operation + 1]
    if end == WHOLE:
        level = steps[step, LEVEL]
        return table[level, FIRST_SEGMENT], table[level + 1, FIRST_SEGMENT]
    return first, end


@jit
def sweep(
    x, b, weight, diagonal, share, edge_e, edge_s, scratch, runs, segments, table, steps, step, channels
):
    """Up to six operations on a level, each on its own range of segments, in one pass through memory.

        interpolation from level + 1, red half sweep, black half sweep,       which end a cycle,
        red half sweep, black half sweep, restriction to level + 1,           which begin one

    They run one behind the other like a wave: black cells follow as soon as the red ones around them are done, and so
    on, while the rows are still in the cache.  Every value is computed from the same values as in six separate passes,
    hence the same bits.

    steps[step]: the level and the ranges.  Returns the bit patterns of the largest change on the finest level, by
    interpolation, by the first black half sweep and by the second one.
    """
    level, kind = steps[step, LEVEL], steps[step, KIND]
    reach, one = table[level, STRIDE], np.float32(1.0)
    corrected = after = before = np.int32(0)
    up, up_end = range_of(steps, step, PROLONG, table)
    red, red_end = range_of(steps, step, RED_AFTER, table)
    black, black_end = range_of(steps, step, BLACK_AFTER, table)
    red_2, red_2_end = range_of(steps, step, RED_BEFORE, table)
    black_2, black_2_end = range_of(steps, step, BLACK_BEFORE, table)
    down, down_end = range_of(steps, step, RESTRICT, table)
    while True:
        # Up to where each operation and all before it are done.
        done_up = segments[up, 0] if up < up_end else FAR_OFF
        done_red = min(done_up, segments[red, 0]) if red < red_end else done_up
        done_black = min(done_red, segments[black, 0]) if black < black_end else done_red
        done_red_2 = min(done_black, segments[red_2, 0]) if red_2 < red_2_end else done_black
        done_black_2 = min(done_red_2, segments[black_2, 0]) if black_2 < black_2_end else done_red_2
        # What comes last goes first, so that a wave is as short as can be.  Relaxation stands here once, for any
        # colour: its loops are most of what there is to compile.
        colour, omega, k = BLACK, one, np.int64(0)
        is_after = is_before = False
        if down < down_end and segments[down, 1] + reach <= done_black_2:
            restrict_segment(
                b, x, diagonal, edge_e, edge_s, scratch, runs, segments, table, level, channels, down
            )
            down += 1
            continue
        if black_2 < black_2_end and segments[black_2, 1] + reach <= done_red_2:
            k, is_before = black_2, True
            black_2 += 1
        elif red_2 < red_2_end and segments[red_2, 1] + reach <= done_black:
            k, colour = red_2, RED
            red_2 += 1
            if kind == SWEEP_FROM_ZERO:
                relax_segment_from_zero(x, b, weight, segments, table, level, channels, k)
                continue
        elif black < black_end and segments[black, 1] + reach <= done_red:
            k, is_after, omega = black, True, OVERRELAXATION if kind == TURN or level == 0 else one
            black += 1
        elif red < red_end and segments[red, 1] + reach <= done_up:
            k, colour = red, RED
            red += 1
        elif up < up_end:
            for channel in range(channels):
                change = prolong_segment(
                    x, share, scratch, runs, segments, table, level, channels, channel, up
                )
                corrected = largest_of(corrected, change)
            up += 1
            continue
        else:
            return corrected, after, before
        change = relax_segment(
            x, b, weight, edge_e, edge_s, segments, table, level, channels, colour, k, omega
        )
        after = largest_of(after, change if is_after else np.int32(0))
        before = largest_of(before, change if is_before else np.int32(0))


# --- the coarsest level, and whole cycles ------------------------------------------------------------------------


@jit
def solve_coarsest(x, b, band, cells, scratch64, table, level, channels):
    """x = A^-1 b on the coarsest level, by its Cholesky factor; returns the bit pattern of the largest change.

    band: (n, bandwidth + 1) float64 from `setup.factor_band`.  cells: (n,) int64, the cells' places in a channel.
    scratch64: (n,) float64.
    """
    n, bandwidth = band.shape[0], band.shape[1] - 1
    largest = np.int32(0)
    for channel in range(channels):
        plane = channels * table[level, OFFSET] + 4 * channel * table[level, QUARTER]
        for i in range(n):
            total = np.float64(b[plane + cells[i]])
            for k in range(1, min(bandwidth, i) + 1):
                total -= band[i, k] * scratch64[i - k]
            scratch64[i] = total * band[i, 0]
        for i in range(n - 1, -1, -1):
            total = scratch64[i]
            for k in range(1, min(bandwidth, n - 1 - i) + 1):
                total -= band[i + k, k] * scratch64[i + k]
            scratch64[i] = total * band[i, 0]
            new = np.float32(scratch64[i])
            largest = largest_of(largest, bits_of(new - x[plane + cells[i]]))
            x[plane + cells[i]] = new
    return largest


@jit
def run_steps(
    changes, x, b, weight, diagonal, share, edge_e, edge_s, band, cells, scratch, scratch64, runs, segments, table,
    steps, channels,
):  # fmt: skip
    """Runs steps of cycles, (n, COLUMNS) int64: what to do, on which level, in which cycle, and the ranges of `sweep`.

    changes: (cycles + 1, 3) int32, raised to the bit patterns of the largest change that the finest level saw in each
    cycle: by the sweep before, by the coarse correction and by the sweep after.
    """
    for step in range(steps.shape[0]):
        kind, level, cycle = steps[step, KIND], steps[step, LEVEL], steps[step, CYCLE]
        after = before = np.int32(0)
        begins, ends = steps[step, RESTRICT + 1] == WHOLE, steps[step, PROLONG + 1] == WHOLE
        if level == 0 and kind != COARSEST and (begins or ends) and rows_pay(runs, segments, table):
            corrected, after, before = sweep_in_rows(
                x, b, weight, diagonal, share, scratch, runs, table, channels, begins, ends
            )
        elif kind == COARSEST:
            corrected = solve_coarsest(x, b, band, cells, scratch64, table, level, channels)
        else:
            corrected, after, before = sweep(
                x,
                b,
                weight,
                diagonal,
                share,
                edge_e,
                edge_s,
                scratch,
                runs,
                segments,
                table,
                steps,
                step,
                channels,
            )
        if level == 0:
            following = cycle + 1 if kind == TURN else cycle
            changes[following, 0] = largest_of(changes[following, 0], before)
            changes[cycle, 1] = largest_of(changes[cycle, 1], corrected)
            changes[cycle, 2] = largest_of(changes[cycle, 2], after)
