"""The steps of a cycle: relaxation, restriction, interpolation, exact solution.

The finest level knows that all its conductances are 1.  Operations take ranges of segments, so that a caller can give
bands to several threads or return to Python in between; a half sweep reads only the other colour, hence any split gives
the same bits.
"""

import numpy as np

from solvers.kernels.policy import inlined, jit
from solvers.layout import COLS, OFFSET, QUARTER, ROWS, STRIDE

DOWN, UP, COARSEST = 0, 1, 2  # see solvers.cycles

RED, BLACK = 0, 1

# Interpolation makes the coarse correction this much larger.  Piecewise constant restriction leaves it a few percent
# too small for smooth errors: 1.04 lowers the convergence factor of F-cycles from 0.102 to 0.092 on a disk, from 0.22
# to 0.14 where one corner alone is known; F- and W-cycles gain on every shape (``python -m benchmarks convergence``).
OVERCORRECTION = 1.04
NEAR, FAR = np.float32(0.75 * OVERCORRECTION), np.float32(0.25 * OVERCORRECTION)

u = np.uint64  # what arrays are indexed with, see solvers.kernels

ABS_BITS = np.int32(0x7FFFFFFF)  # all but the sign of a float32


@inlined
def bits_of(value):
    """The bit pattern of |value|: as integers these order like the values, with NaN on top."""
    return np.float32(value).view(np.int32) & ABS_BITS


@inlined
def largest_of(a, b):
    """The larger one of two bit patterns."""
    return a if a > b else b


# --- relaxation --------------------------------------------------------------------------------------------------


@inlined
def relax_finest(x, b, weight, size, stride, plane, quarter, at, n):
    """Gauss-Seidel on n places of one quarter of the finest level, from `at` on, in the channel that begins at `plane`.

    Returns the bit pattern of the largest absolute change.
    """
    w = u(quarter * size + at)
    own = u(plane + quarter * size + at)
    north = u(plane + (quarter ^ 2) * size + at - (0 if quarter & 2 else stride))
    south = north + u(stride)
    west = u(plane + (quarter ^ 1) * size + at - (0 if quarter & 1 else 1))
    east = west + u(1)
    largest = np.int32(0)
    for i in range(u(n)):
        new = weight[w + i] * (b[own + i] + x[north + i] + x[south + i] + x[west + i] + x[east + i])
        largest = max(largest, bits_of(new - x[own + i]))
        x[own + i] = new
    return largest


@inlined
def relax_coarse(x, b, weight, edge_e, edge_s, scratch, size, stride, plane, offset, skip, quarter, at, n):
    """The same on a coarse level, whose coefficients begin at `offset`, and at `skip` less in the edge fields."""
    here = quarter * size + at
    above = (quarter ^ 2) * size + at - (0 if quarter & 2 else stride)
    beside = (quarter ^ 1) * size + at - (0 if quarter & 1 else 1)
    own, w, c_own = u(plane + here), u(offset + here), u(offset - skip + here)
    north, c_north = u(plane + above), u(offset - skip + above)
    west, c_west = u(plane + beside), u(offset - skip + beside)
    south, east = north + u(stride), west + u(1)
    for i in range(u(n)):
        scratch[i] = b[own + i] + edge_s[c_north + i] * x[north + i] + edge_s[c_own + i] * x[south + i]
    for i in range(u(n)):
        around = scratch[i] + edge_e[c_west + i] * x[west + i] + edge_e[c_own + i] * x[east + i]
        x[own + i] = weight[w + i] * around


@jit
def relax_over(x, b, weight, segments, table, channels, colour, omega, first, end):
    """Half sweep of over-relaxation by `omega` (float32) over segments [first, end) of the finest level."""
    stride, size = table[0, STRIDE], table[0, QUARTER]
    for channel in range(channels):
        plane = 4 * channel * size
        for k in range(first, end):
            at = segments[k, 0]
            for quarter in (colour, 3 - colour):
                w = u(quarter * size + at)
                own = u(plane + quarter * size + at)
                north = u(plane + (quarter ^ 2) * size + at - (0 if quarter & 2 else stride))
                south = north + u(stride)
                west = u(plane + (quarter ^ 1) * size + at - (0 if quarter & 1 else 1))
                east = west + u(1)
                for i in range(u(segments[k, 1] - at)):
                    around = b[own + i] + x[north + i] + x[south + i] + x[west + i] + x[east + i]
                    x[own + i] += omega * (weight[w + i] * around - x[own + i])


@inlined
def relax_segment(x, b, weight, edge_e, edge_s, scratch, segments, table, level, plane, skip, colour, k):
    """Gauss-Seidel on the two quarters of one colour; returns the largest change on the finest level."""
    stride, size, offset = table[level, STRIDE], table[level, QUARTER], table[level, OFFSET]
    at, n = segments[k, 0], segments[k, 1] - segments[k, 0]
    largest = np.int32(0)
    for quarter in (colour, 3 - colour):
        if level == 0:
            change = relax_finest(x, b, weight, size, stride, plane, quarter, at, n)
            largest = largest_of(largest, change)
        else:
            relax_coarse(
                x, b, weight, edge_e, edge_s, scratch, size, stride, plane, offset, skip, quarter, at, n
            )
    return largest


# --- restriction -------------------------------------------------------------------------------------------------


@inlined
def add_residual_finest(scratch, x, b, weight, diagonal, size, stride, plane, quarter, at, n):
    """scratch += residual of n places of one quarter of the finest level."""
    w = u(quarter * size + at)
    own = u(plane + quarter * size + at)
    north = u(plane + (quarter ^ 2) * size + at - (0 if quarter & 2 else stride))
    south = north + u(stride)
    west = u(plane + (quarter ^ 1) * size + at - (0 if quarter & 1 else 1))
    east = west + u(1)
    for i in range(u(n)):  # outside the region the sum means nothing, but weight and diagonal are zero there
        around = b[own + i] + x[north + i] + x[south + i] + x[west + i] + x[east + i]
        scratch[i] += diagonal[w + i] * (weight[w + i] * around - x[own + i])


@inlined
def add_residual_coarse(
    scratch, x, b, diagonal, edge_e, edge_s, size, stride, plane, offset, skip, quarter, at, n
):
    """scratch += residual of n places of one quarter of a coarse level."""
    here = quarter * size + at
    above = (quarter ^ 2) * size + at - (0 if quarter & 2 else stride)
    beside = (quarter ^ 1) * size + at - (0 if quarter & 1 else 1)
    own, d, c_own = u(plane + here), u(offset + here), u(offset - skip + here)
    north, c_north = u(plane + above), u(offset - skip + above)
    west, c_west = u(plane + beside), u(offset - skip + beside)
    south, east = north + u(stride), west + u(1)
    for i in range(u(n)):
        scratch[i] += b[own + i] - diagonal[d + i] * x[own + i] + edge_s[c_north + i] * x[north + i]
    for i in range(u(n)):
        around = edge_e[c_west + i] * x[west + i] + edge_e[c_own + i] * x[east + i]
        scratch[i] += edge_s[c_own + i] * x[south + i] + around


@inlined
def hand_down(x, b, scratch, start, n, at, size):
    """n sums from scratch[start] on become right-hand sides of level + 1, even columns at `at`; x there is zeroed."""
    even, odd, first, half = u(at), u(at + size), u(start), u(n // 2)
    for i in range(half):
        b[even + i] = scratch[first + i + i]
    for i in range(half):
        b[odd + i] = scratch[first + i + i + u(1)]
    for i in range(half):
        x[even + i] = np.float32(0.0)
    for i in range(half):
        x[odd + i] = np.float32(0.0)


@inlined
def restrict_segment(
    x, b, weight, diagonal, edge_e, edge_s, scratch, runs, segments, table, level, channels, channel, k
):
    """Right-hand side of level + 1 below a segment: each cell the sum of its children's residuals.  Its x becomes zero.

    A black half sweep must have come before: black residuals are then zero, and only the red ones are computed.
    """
    stride, size, offset = table[level, STRIDE], table[level, QUARTER], table[level, OFFSET]
    plane = channels * offset + 4 * channel * size
    at = segments[k, 0]
    n = segments[k, 1] - at
    for i in range(u(n)):
        scratch[i] = np.float32(0.0)
    for quarter in (0, 3):
        if level == 0:
            add_residual_finest(scratch, x, b, weight, diagonal, size, stride, plane, quarter, at, n)
        else:
            skip = table[1, OFFSET]
            add_residual_coarse(
                scratch, x, b, diagonal, edge_e, edge_s, size, stride, plane, offset, skip, quarter, at, n
            )
    coarse_size = table[level + 1, QUARTER]
    plane = channels * table[level + 1, OFFSET] + 4 * channel * coarse_size
    for run in range(segments[k, 2], segments[k, 3]):
        row, low = np.int64(runs[run, 0]), np.int64(runs[run, 1])
        to = plane + 2 * (row & 1) * coarse_size + (row // 2 + 1) * table[level + 1, STRIDE] + low // 2
        hand_down(x, b, scratch, (row + 1) * stride + low - at, np.int64(runs[run, 2]) - low, to, coarse_size)


# --- interpolation -----------------------------------------------------------------------------------------------


@inlined
def blend_run(scratch, x, table, level, channels, channel, quarter, row, low, high, at):
    """scratch[at + 1 : ...] = the cells of level + 1 in columns [low, high), blended for the children in `quarter`.

    3/4 of a cell's own row and 1/4 of the row that the child leans to.  Quarter 1 holds the upper right children: they
    also need column `high`, which follows.  Quarter 2 holds the lower left ones: column low - 1 comes before, at
    scratch[at].  An inactive cell counts as 0, and the grid continues with its edge.
    """
    rows, cols = table[level, ROWS], table[level, COLS]
    stride, size = table[level + 1, STRIDE], table[level + 1, QUARTER]
    far_row = max(row - 1, 0) if quarter == 1 else min(row + 1, rows - 1)
    plane = channels * table[level + 1, OFFSET] + 4 * channel * size + low // 2
    near = u(plane + 2 * (row & 1) * size + (row // 2 + 1) * stride)
    far = u(plane + 2 * (far_row & 1) * size + (far_row // 2 + 1) * stride)
    near_odd, far_odd = near + u(size), far + u(size)
    first, half = u(at + 1), u((high - low) // 2)
    for i in range(half):
        scratch[first + i + i] = NEAR * x[near + i] + FAR * x[far + i]
        scratch[first + i + i + u(1)] = NEAR * x[near_odd + i] + FAR * x[far_odd + i]
    if quarter == 1:
        if high < cols:
            scratch[first + half + half] = NEAR * x[near + half] + FAR * x[far + half]
        else:
            scratch[at + 1 + cols - low] = scratch[at + cols - low]
    elif low > 0:
        scratch[at] = NEAR * x[near_odd - u(1)] + FAR * x[far_odd - u(1)]
    else:
        scratch[at] = scratch[at + 1]


@inlined
def prolong_segment(x, weight, scratch, runs, segments, table, level, channels, channel, k):
    """Adds the 9-3-3-1 interpolation of level + 1 to the black cells of a segment.

    Only black ones: the next half sweep overwrites the red ones without reading them.  Returns the bit pattern of the
    largest absolute change.
    """
    stride, size, offset = table[level, STRIDE], table[level, QUARTER], table[level, OFFSET]
    near, far, zero = np.float32(0.75), np.float32(0.25), np.float32(0.0)
    largest = np.int32(0)
    at = segments[k, 0]
    for quarter in (1, 2):
        for run in range(segments[k, 2], segments[k, 3]):
            row, low, high = np.int64(runs[run, 0]), np.int64(runs[run, 1]), np.int64(runs[run, 2])
            to = (row + 1) * stride + low - at
            blend_run(scratch, x, table, level, channels, channel, quarter, row, low, high, to)
        w = u(offset + quarter * size + at)
        own = u(channels * offset + (4 * channel + quarter) * size + at)
        here, beside = u(1), u(4 - 2 * quarter)
        for i in range(u(segments[k, 1] - at)):
            change = near * scratch[here + i] + far * scratch[beside + i] if weight[w + i] > zero else zero
            largest = max(largest, bits_of(change))
            x[own + i] += change
    return largest


# --- one visit to a level ----------------------------------------------------------------------------------------


@jit
def sweep(
    x, b, weight, diagonal, edge_e, edge_s, scratch, runs, segments, table, level, channels,
    prolong_from, prolong_to, red_from, red_to, black_from, black_to, restrict_from, restrict_to,
):  # fmt: skip
    """Up to four operations on a level, each on its own range of segments, in one pass through memory.

    Interpolation from level + 1, red half sweep, black half sweep, restriction to level + 1.  They run one behind the
    other like a wave: black cells follow as soon as the red ones around them are done, and so on, while the rows are
    still in the cache.  Every value is computed from the same values as in four separate passes, hence the same bits.

    Returns the bit patterns of the largest change on the finest level, by interpolation and by the black half sweep.
    """
    stride, size, offset = table[level, STRIDE], table[level, QUARTER], table[level, OFFSET]
    skip = table[1, OFFSET]
    far_off = np.int64(1) << 62
    by_correction = by_sweep = np.int32(0)
    for channel in range(channels):
        plane = channels * offset + 4 * channel * size
        p, r, k, d = prolong_from, red_from, black_from, restrict_from
        # What comes last goes first, so that a wave is as short as can be: residuals of what no black cell to come
        # touches, black cells that no red one to come touches, and red ones once everything they read is interpolated.
        while True:
            red_start = segments[r, 0] if r < red_to else far_off
            black_start = segments[k, 0] if k < black_to else red_start
            if d < restrict_to and segments[d, 1] + stride + 1 <= black_start:
                restrict_segment(
                    x,
                    b,
                    weight,
                    diagonal,
                    edge_e,
                    edge_s,
                    scratch,
                    runs,
                    segments,
                    table,
                    level,
                    channels,
                    channel,
                    d,
                )
                d += 1
                continue
            black = k < black_to and segments[k, 1] + stride + 1 <= red_start
            if not black and p < prolong_to and (r >= red_to or segments[p, 0] < segments[r, 1] + stride + 1):
                change = prolong_segment(
                    x, weight, scratch, runs, segments, table, level, channels, channel, p
                )
                by_correction = largest_of(by_correction, change)
                p += 1
                continue
            if not black and r >= red_to:
                break
            at = k if black else r
            colour = 1 if black else 0
            change = relax_segment(
                x, b, weight, edge_e, edge_s, scratch, segments, table, level, plane, skip, colour, at
            )
            if black:
                by_sweep = largest_of(by_sweep, change)
                k += 1
            else:
                r += 1
    return by_correction, by_sweep


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
            scratch64[i] = total / band[i, 0]
        for i in range(n - 1, -1, -1):
            total = scratch64[i]
            for k in range(1, min(bandwidth, n - 1 - i) + 1):
                total -= band[i + k, k] * scratch64[i + k]
            scratch64[i] = total / band[i, 0]
            new = np.float32(scratch64[i])
            largest = max(largest, bits_of(new - x[plane + cells[i]]))
            x[plane + cells[i]] = new
    return largest


@jit
def run_steps(
    x,
    b,
    weight,
    diagonal,
    edge_e,
    edge_s,
    band,
    cells,
    scratch,
    scratch64,
    runs,
    segments,
    table,
    steps,
    channels,
):
    """Runs steps of a cycle, (n, 10) int64: what to do, on which level, and the eight bounds of `sweep`.

    Returns the bit patterns of the largest change that the finest level saw: by the sweep before, by the
    coarse correction and by the sweep after.  Their sum bounds the change of any black cell in this cycle.
    """
    before = correction = after = np.int32(0)
    for k in range(steps.shape[0]):
        step, level = steps[k, 0], steps[k, 1]
        if step == COARSEST:
            change = solve_coarsest(x, b, band, cells, scratch64, table, level, channels)
            if level == 0:
                correction = change
            continue
        corrected, change = sweep(
            x, b, weight, diagonal, edge_e, edge_s, scratch, runs, segments, table, level, channels,
            steps[k, 2], steps[k, 3], steps[k, 4], steps[k, 5], steps[k, 6], steps[k, 7], steps[k, 8], steps[k, 9],
        )  # fmt: skip
        if level == 0 and step == UP:
            correction, after = largest_of(correction, corrected), largest_of(after, change)
        elif level == 0:
            before = largest_of(before, change)
    return before, correction, after
