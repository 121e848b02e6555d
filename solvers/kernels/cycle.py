"""The steps of a cycle: relaxation, restriction, interpolation, exact solution.

The finest level knows that all its conductances are 1.  Operations take ranges of segments, so that a caller can give
bands to several threads or return to Python in between; a half sweep reads only the other colour, hence any split gives
the same bits.
"""

import numpy as np

from solvers.kernels.policy import jit
from solvers.layout import COLS, OFFSET, QUARTER, ROWS, STRIDE

DOWN, UP, COARSEST = 0, 1, 2  # see solvers.cycles

RED, BLACK = 0, 1

# Interpolation makes the coarse correction this much larger.  Piecewise constant restriction leaves it a few percent
# too small for smooth errors: 1.04 lowers the convergence factor of F-cycles from 0.102 to 0.092 on a disk, from 0.22
# to 0.14 where one corner alone is known, and is never worse (``python -m benchmarks convergence``).
OVERCORRECTION = 1.04
NEAR, FAR = np.float32(0.75 * OVERCORRECTION), np.float32(0.25 * OVERCORRECTION)

ABS_BITS = np.int32(0x7FFFFFFF)  # all but the sign of a float32


@jit
def bits_of(value):
    """The bit pattern of |value|: as integers these order like the values, with NaN on top."""
    return np.float32(value).view(np.int32) & ABS_BITS


@jit
def largest_of(a, b):
    """The larger one of two bit patterns."""
    return a if a > b else b


# --- relaxation --------------------------------------------------------------------------------------------------


@jit
def relax_finest(x, b, weight, size, stride, plane, quarter, at, n):
    """Gauss-Seidel on n places of one quarter of the finest level, from `at` on, in the channel that begins at `plane`.

    Returns the bit pattern of the largest absolute change.
    """
    o = quarter * size + at
    w, own, rhs = weight[o : o + n], x[plane + o : plane + o + n], b[plane + o : plane + o + n]
    o = plane + (quarter ^ 2) * size + at - (0 if quarter & 2 else stride)
    north, south = x[o : o + n], x[o + stride : o + stride + n]
    o = plane + (quarter ^ 1) * size + at - (0 if quarter & 1 else 1)
    west, east = x[o : o + n], x[o + 1 : o + 1 + n]
    largest = np.int32(0)
    for i in range(n):
        new = w[i] * (rhs[i] + north[i] + south[i] + west[i] + east[i])
        largest = max(largest, bits_of(new - own[i]))
        own[i] = new
    return largest


@jit
def relax_coarse(
    x, b, weight, edge_e, edge_s, scratch, size, stride, plane, coefficients, skip, quarter, at, n
):
    """The same on a coarse level, whose coefficients begin at `coefficients`, and at `skip` less in the edge fields."""
    o = quarter * size + at
    own, rhs, w = x[plane + o : plane + o + n], b[plane + o : plane + o + n], weight[coefficients + o :][:n]
    o += coefficients - skip
    c_south, c_east = edge_s[o : o + n], edge_e[o : o + n]
    o = (quarter ^ 2) * size + at - (0 if quarter & 2 else stride)
    north, south = x[plane + o : plane + o + n], x[plane + o + stride : plane + o + stride + n]
    o += coefficients - skip
    c_north = edge_s[o : o + n]
    o = (quarter ^ 1) * size + at - (0 if quarter & 1 else 1)
    west, east = x[plane + o : plane + o + n], x[plane + o + 1 : plane + o + 1 + n]
    o += coefficients - skip
    c_west = edge_e[o : o + n]
    total = scratch[:n]
    for i in range(n):
        total[i] = rhs[i] + c_north[i] * north[i] + c_south[i] * south[i]
    for i in range(n):
        own[i] = w[i] * (total[i] + c_west[i] * west[i] + c_east[i] * east[i])


@jit
def relax_over(x, b, weight, segments, table, channels, colour, omega, first, end):
    """Half sweep of over-relaxation by `omega` (float32) over segments [first, end) of the finest level."""
    stride, size = table[0, STRIDE], table[0, QUARTER]
    for channel in range(channels):
        plane = 4 * channel * size
        for k in range(first, end):
            at = segments[k, 0]
            n = segments[k, 1] - at
            for quarter in (colour, 3 - colour):
                o = quarter * size + at
                w, own, rhs = weight[o : o + n], x[plane + o : plane + o + n], b[plane + o : plane + o + n]
                o = plane + (quarter ^ 2) * size + at - (0 if quarter & 2 else stride)
                north, south = x[o : o + n], x[o + stride : o + stride + n]
                o = plane + (quarter ^ 1) * size + at - (0 if quarter & 1 else 1)
                west, east = x[o : o + n], x[o + 1 : o + 1 + n]
                for i in range(n):
                    own[i] += omega * (w[i] * (rhs[i] + north[i] + south[i] + west[i] + east[i]) - own[i])


# --- restriction -------------------------------------------------------------------------------------------------


@jit
def add_residual_finest(total, x, b, weight, diagonal, plane, size, stride, quarter, at):
    """total += residual of a stretch of one quarter of the finest level."""
    n = total.shape[0]
    o = quarter * size + at
    w, d, own, rhs = (
        weight[o : o + n],
        diagonal[o : o + n],
        x[plane + o : plane + o + n],
        b[plane + o : plane + o + n],
    )
    o = plane + (quarter ^ 2) * size + at - (0 if quarter & 2 else stride)
    north, south = x[o : o + n], x[o + stride : o + stride + n]
    o = plane + (quarter ^ 1) * size + at - (0 if quarter & 1 else 1)
    west, east = x[o : o + n], x[o + 1 : o + 1 + n]
    for i in range(n):  # outside the region the sum means nothing, but weight and diagonal are zero there
        total[i] += d[i] * (w[i] * (rhs[i] + north[i] + south[i] + west[i] + east[i]) - own[i])


@jit
def add_residual_coarse(
    total, x, b, diagonal, edge_e, edge_s, plane, coefficients, skip, size, stride, quarter, at
):
    """total += residual of a stretch of one quarter of a coarse level."""
    n = total.shape[0]
    o = quarter * size + at
    own, rhs = x[plane + o : plane + o + n], b[plane + o : plane + o + n]
    o += coefficients
    d = diagonal[o : o + n]
    o -= skip
    c_south, c_east = edge_s[o : o + n], edge_e[o : o + n]
    o = (quarter ^ 2) * size + at - (0 if quarter & 2 else stride)
    north, south = x[plane + o : plane + o + n], x[plane + o + stride : plane + o + stride + n]
    o += coefficients - skip
    c_north = edge_s[o : o + n]
    for i in range(n):
        total[i] += rhs[i] - d[i] * own[i] + c_north[i] * north[i]
    o = (quarter ^ 1) * size + at - (0 if quarter & 1 else 1)
    west, east = x[plane + o : plane + o + n], x[plane + o + 1 : plane + o + 1 + n]
    o += coefficients - skip
    c_west = edge_e[o : o + n]
    for i in range(n):
        total[i] += c_south[i] * south[i] + c_east[i] * east[i] + c_west[i] * west[i]


@jit
def hand_down(x, b, sums, table, level, channels, channel, row, low):
    """Sums of residuals along a row of places become the right-hand side of the cells of level + 1 there."""
    stride, size = table[level + 1, STRIDE], table[level + 1, QUARTER]
    n = sums.shape[0] // 2
    o = channels * table[level + 1, OFFSET] + (4 * channel + 2 * (row & 1)) * size
    o += (row // 2 + 1) * stride + low // 2
    even, odd = b[o : o + n], b[o + size : o + size + n]
    for i in range(n):
        even[i] = sums[2 * i]
        odd[i] = sums[2 * i + 1]
    even, odd = x[o : o + n], x[o + size : o + size + n]
    for i in range(n):
        even[i] = 0
        odd[i] = 0


@jit
def restrict_segment(
    x, b, weight, diagonal, edge_e, edge_s, scratch, runs, segments, table, level, channels, channel, k
):
    """Right-hand side of level + 1 below a segment: each cell the sum of its children's residuals.  Its x becomes zero.

    A black half sweep must have come before: black residuals are then zero, and only the red ones are computed.
    """
    stride, size, offset = table[level, STRIDE], table[level, QUARTER], table[level, OFFSET]
    plane = channels * offset + 4 * channel * size
    at = segments[k, 0]
    total = scratch[: segments[k, 1] - at]
    for i in range(total.shape[0]):
        total[i] = 0
    for quarter in (0, 3):
        if level == 0:
            add_residual_finest(total, x, b, weight, diagonal, plane, size, stride, quarter, at)
        else:
            add_residual_coarse(
                total,
                x,
                b,
                diagonal,
                edge_e,
                edge_s,
                plane,
                offset,
                table[1, OFFSET],
                size,
                stride,
                quarter,
                at,
            )
    for run in range(segments[k, 2], segments[k, 3]):
        row, low, n = np.int64(runs[run, 0]), np.int64(runs[run, 1]), np.int64(runs[run, 2]) - runs[run, 1]
        o = (row + 1) * stride + low - at
        hand_down(x, b, total[o : o + n], table, level, channels, channel, row, low)


# --- interpolation -----------------------------------------------------------------------------------------------


@jit
def blend_rows(line, x, near_at, far_at, size):
    """line = 3/4 of one row of cells and 1/4 of another, put together from the quarters of even and odd columns."""
    n = line.shape[0] // 2
    near_even, near_odd = x[near_at : near_at + n], x[near_at + size : near_at + size + n]
    far_even, far_odd = x[far_at : far_at + n], x[far_at + size : far_at + size + n]
    for i in range(n):
        line[2 * i] = NEAR * near_even[i] + FAR * far_even[i]
        line[2 * i + 1] = NEAR * near_odd[i] + FAR * far_odd[i]


@jit
def blend_run(line, x, table, level, channels, channel, quarter, row, low, high):
    """line[1 : -1] = the cells of level + 1 in columns [low, high), blended for the children in `quarter`.

    Quarter 1 holds the upper right child of each cell, which leans to the row above and the column to the right: the
    column `high` follows in line[-1].  Quarter 2 holds the lower left child: column low - 1 goes into line[0].  An
    inactive cell counts as 0, and the grid continues with its edge.
    """
    rows, cols = table[level, ROWS], table[level, COLS]
    stride, size = table[level + 1, STRIDE], table[level + 1, QUARTER]
    far_row = max(row - 1, 0) if quarter == 1 else min(row + 1, rows - 1)
    plane = channels * table[level + 1, OFFSET] + 4 * channel * size + low // 2
    near_at = plane + 2 * (row & 1) * size + (row // 2 + 1) * stride
    far_at = plane + 2 * (far_row & 1) * size + (far_row // 2 + 1) * stride
    n = high - low
    blend_rows(line[1 : n + 1], x, near_at, far_at, size)
    if quarter == 1:
        if high < cols:
            line[n + 1] = NEAR * x[near_at + n // 2] + FAR * x[far_at + n // 2]
        else:
            line[cols - low + 1] = line[cols - low]
    elif low > 0:
        line[0] = NEAR * x[near_at + size - 1] + FAR * x[far_at + size - 1]
    else:
        line[0] = line[1]


@jit
def prolong_segment(x, weight, scratch, runs, segments, table, level, channels, channel, k):
    """Adds the 9-3-3-1 interpolation of level + 1 to the black cells of a segment.

    Only black ones: the next half sweep overwrites the red ones without reading them.  Returns the bit pattern of the
    largest absolute change.
    """
    stride, size, offset = table[level, STRIDE], table[level, QUARTER], table[level, OFFSET]
    near, far, zero = np.float32(0.75), np.float32(0.25), np.float32(0.0)
    largest = np.int32(0)
    at = segments[k, 0]
    n = segments[k, 1] - at
    for quarter in (1, 2):
        for run in range(segments[k, 2], segments[k, 3]):
            row, low, high = np.int64(runs[run, 0]), np.int64(runs[run, 1]), np.int64(runs[run, 2])
            o = (row + 1) * stride + low - at
            line = scratch[o : o + high - low + 2]
            blend_run(line, x, table, level, channels, channel, quarter, row, low, high)
        here, beside = scratch[1 : 1 + n], scratch[4 - 2 * quarter : 4 - 2 * quarter + n]
        o = offset + quarter * size + at
        w = weight[o : o + n]
        o += (channels - 1) * offset + 4 * channel * size
        own = x[o : o + n]
        for i in range(n):
            change = near * here[i] + far * beside[i] if w[i] > zero else zero
            largest = max(largest, bits_of(change))
            own[i] += change
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
        while True:
            # Interpolation goes ahead of the red segment at hand, as far as that one reads.
            reach = segments[r, 1] + stride + 1 if r < red_to else far_off
            while p < prolong_to and segments[p, 0] < reach:
                change = prolong_segment(
                    x, weight, scratch, runs, segments, table, level, channels, channel, p
                )
                by_correction = largest_of(by_correction, change)
                p += 1
            if r < red_to:
                relax_segment(
                    x, b, weight, edge_e, edge_s, scratch, segments, table, level, plane, skip, 0, r
                )
                r += 1
            # Black cells follow once no red one that is still to come touches them,
            clear = segments[r, 0] if r < red_to else far_off
            while k < black_to and segments[k, 1] + stride + 1 <= clear:
                change = relax_segment(
                    x, b, weight, edge_e, edge_s, scratch, segments, table, level, plane, skip, 1, k
                )
                by_sweep = largest_of(by_sweep, change)
                k += 1
            # and residuals once no black one does.
            clear = segments[k, 0] if k < black_to else clear
            while d < restrict_to and segments[d, 1] + stride + 1 <= clear:
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
            if r >= red_to and k >= black_to and p >= prolong_to and d >= restrict_to:
                break
    return by_correction, by_sweep


@jit
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
