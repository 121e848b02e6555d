"""The steps of a cycle: relaxation, restriction, interpolation, exact solution.

The finest level knows that all its conductances are 1.  Its kernels take ranges of rows of places, so that a caller can
give bands to several threads or return to Python in between; a half sweep reads only the other colour, hence any
split gives the same bits.
"""

import numpy as np

from solvers.kernels.policy import jit
from solvers.layout import COLS, FIRST_RUN, FIRST_SEGMENT, OFFSET, QUARTER, ROWS, STRIDE

DOWN, UP, COARSEST = 0, 1, 2  # see solvers.cycles

RED, BLACK = 0, 1

ABS_BITS = np.int32(0x7FFFFFFF)  # all but the sign of a float32


@jit
def bits_of(value):
    """The bit pattern of |value|: as integers these order like the values, with NaN on top."""
    return np.float32(value).view(np.int32) & ABS_BITS


@jit
def first_run_of(runs, start, end, row):
    """The first of runs[start:end] that lies in `row` or below it; runs are sorted by row."""
    while start < end:
        middle = (start + end) // 2
        if runs[middle, 0] < row:
            start = middle + 1
        else:
            end = middle
    return start


# --- relaxation --------------------------------------------------------------------------------------------------


@jit
def relax_finest(x, b, weight, runs, table, channels, colour, first_row, end_row):
    """Gauss-Seidel half sweep over one colour of rows [first_row, end_row) of the finest level.

    Returns the bit pattern of the largest absolute change.
    """
    stride, size = table[0, STRIDE], table[0, QUARTER]
    start, end = table[0, FIRST_RUN], table[1, FIRST_RUN]
    first, end = first_run_of(runs, start, end, first_row), first_run_of(runs, start, end, end_row)
    largest = np.int32(0)
    for channel in range(channels):
        plane = 4 * channel * size
        for k in range(first, end):
            at = (np.int64(runs[k, 0]) + 1) * stride + runs[k, 1]
            n = np.int64(runs[k, 2]) - runs[k, 1]
            for quarter in (colour, 3 - colour):
                o = quarter * size + at
                w, own, rhs = weight[o : o + n], x[plane + o : plane + o + n], b[plane + o : plane + o + n]
                o = plane + (quarter ^ 2) * size + at - (0 if quarter & 2 else stride)
                north, south = x[o : o + n], x[o + stride : o + stride + n]
                o = plane + (quarter ^ 1) * size + at - (0 if quarter & 1 else 1)
                west, east = x[o : o + n], x[o + 1 : o + 1 + n]
                for i in range(n):
                    new = w[i] * (rhs[i] + north[i] + south[i] + west[i] + east[i])
                    largest = max(largest, bits_of(new - own[i]))
                    own[i] = new
    return largest


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


@jit
def relax_coarse(x, b, weight, edge_e, edge_s, scratch, segments, table, level, channels, colour):
    """Gauss-Seidel half sweep over one colour of a coarse level.  scratch: as long as a segment."""
    stride, size, offset = table[level, STRIDE], table[level, QUARTER], table[level, OFFSET]
    skip = table[1, OFFSET]
    for k in range(table[level, FIRST_SEGMENT], table[level + 1, FIRST_SEGMENT]):
        at = segments[k, 0]
        n = segments[k, 1] - at
        total = scratch[:n]
        for quarter in (colour, 3 - colour):
            own_at = quarter * size + at
            vertical = (quarter ^ 2) * size + at - (0 if quarter & 2 else stride)
            horizontal = (quarter ^ 1) * size + at - (0 if quarter & 1 else 1)
            o = offset + own_at
            w = weight[o : o + n]
            o -= skip
            c_south, c_east = edge_s[o : o + n], edge_e[o : o + n]
            o = offset - skip + vertical
            c_north = edge_s[o : o + n]
            o = offset - skip + horizontal
            c_west = edge_e[o : o + n]
            for channel in range(channels):
                plane = channels * offset + 4 * channel * size
                o = plane + own_at
                own, rhs = x[o : o + n], b[o : o + n]
                o = plane + vertical
                north, south = x[o : o + n], x[o + stride : o + stride + n]
                o = plane + horizontal
                west, east = x[o : o + n], x[o + 1 : o + 1 + n]
                for i in range(n):
                    total[i] = rhs[i] + c_north[i] * north[i] + c_south[i] * south[i]
                for i in range(n):
                    own[i] = w[i] * (total[i] + c_west[i] * west[i] + c_east[i] * east[i])


# --- restriction -------------------------------------------------------------------------------------------------


@jit
def add_residual_finest(total, x, b, weight, diagonal, plane, size, stride, quarter, at):
    """total += residual of a stretch of one quarter of the finest level."""
    n = total.shape[0]
    o = quarter * size + at
    w, d, own, rhs = weight[o : o + n], diagonal[o : o + n], x[plane + o : plane + o + n], b[plane + o : plane + o + n]
    o = plane + (quarter ^ 2) * size + at - (0 if quarter & 2 else stride)
    north, south = x[o : o + n], x[o + stride : o + stride + n]
    o = plane + (quarter ^ 1) * size + at - (0 if quarter & 1 else 1)
    west, east = x[o : o + n], x[o + 1 : o + 1 + n]
    for i in range(n):  # outside the region the sum means nothing, but weight and diagonal are zero there
        total[i] += d[i] * (w[i] * (rhs[i] + north[i] + south[i] + west[i] + east[i]) - own[i])


@jit
def add_residual_coarse(total, x, b, diagonal, edge_e, edge_s, plane, coefficients, skip, size, stride, quarter, at):
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
def hand_down(x, b, scratch, table, level, channels, channel, row, low, n):
    """scratch[:n], sums of residuals along a row of places, becomes the right-hand side of the cells of level + 1."""
    stride, size = table[level + 1, STRIDE], table[level + 1, QUARTER]
    o = channels * table[level + 1, OFFSET] + (4 * channel + 2 * (row & 1)) * size
    o += (row // 2 + 1) * stride + low // 2
    even, odd = b[o : o + n // 2], b[o + size : o + size + n // 2]
    for i in range(n // 2):
        even[i] = scratch[2 * i]
        odd[i] = scratch[2 * i + 1]
    even, odd = x[o : o + n // 2], x[o + size : o + size + n // 2]
    for i in range(n // 2):
        even[i] = 0
        odd[i] = 0


@jit
def restrict_residual(x, b, weight, diagonal, edge_e, edge_s, scratch, runs, table, level, channels, first_row, end_row):
    """Right-hand side of level + 1: each cell the sum of its children's residuals.  Its unknowns become zero.

    A black half sweep must have come before: black residuals are then zero, and only the red ones are computed.
    [first_row, end_row): rows of places of `level`, which are rows of cells of level + 1.
    """
    stride, size, offset = table[level, STRIDE], table[level, QUARTER], table[level, OFFSET]
    start, end = table[level, FIRST_RUN], table[level + 1, FIRST_RUN]
    first, end = first_run_of(runs, start, end, first_row), first_run_of(runs, start, end, end_row)
    for channel in range(channels):
        plane = channels * offset + 4 * channel * size
        for k in range(first, end):
            row, low = np.int64(runs[k, 0]), np.int64(runs[k, 1])
            n = np.int64(runs[k, 2]) - low
            at = (row + 1) * stride + low
            total = scratch[:n]
            for i in range(n):
                total[i] = 0
            for quarter in (0, 3):
                if level == 0:
                    add_residual_finest(total, x, b, weight, diagonal, plane, size, stride, quarter, at)
                else:
                    add_residual_coarse(
                        total, x, b, diagonal, edge_e, edge_s, plane, offset, table[1, OFFSET], size, stride, quarter, at
                    )
            hand_down(x, b, scratch, table, level, channels, channel, row, low, n)


# --- interpolation -----------------------------------------------------------------------------------------------


@jit
def blend_rows(line, x, table, level, channels, channel, near_row, far_row, low):
    """line = 3/4 of one row of cells of `level` and 1/4 of another, from column `low` on (even, -2 at least)."""
    stride, size = table[level, STRIDE], table[level, QUARTER]
    near, far = np.float32(0.75), np.float32(0.25)
    n = line.shape[0] // 2
    plane = channels * table[level, OFFSET] + 4 * channel * size
    a = plane + 2 * (near_row & 1) * size + (near_row // 2 + 1) * stride + low // 2
    c = plane + 2 * (far_row & 1) * size + (far_row // 2 + 1) * stride + low // 2
    near_even, near_odd = x[a : a + n], x[a + size : a + size + n]
    far_even, far_odd = x[c : c + n], x[c + size : c + size + n]
    for i in range(n):
        line[2 * i] = near * near_even[i] + far * far_even[i]
        line[2 * i + 1] = near * near_odd[i] + far * far_odd[i]


@jit
def prolong(x, weight, scratch, runs, table, level, channels, first_row, end_row):
    """Adds the 9-3-3-1 interpolation of level + 1 to the black cells of rows of places [first_row, end_row).

    Only black ones: the next half sweep overwrites the red ones without reading them.  An inactive coarse cell counts
    as 0, and the grid continues with its edge.  Returns the bit pattern of the largest absolute change.
    """
    stride, size, offset = table[level, STRIDE], table[level, QUARTER], table[level, OFFSET]
    rows, cols = table[level, ROWS], table[level, COLS]
    start, end = table[level, FIRST_RUN], table[level + 1, FIRST_RUN]
    first, end = first_run_of(runs, start, end, first_row), first_run_of(runs, start, end, end_row)
    near, far, zero = np.float32(0.75), np.float32(0.25), np.float32(0.0)
    largest = np.int32(0)
    for channel in range(channels):
        for k in range(first, end):
            row, low = np.int64(runs[k, 0]), np.int64(runs[k, 1])
            n = np.int64(runs[k, 2]) - low
            line = scratch[: n + 4]  # coarse cells low - 2 ... high + 1
            for quarter in (1, 2):
                # Quarter 1 has the upper right child of each coarse cell, quarter 2 the lower left one.
                far_row = max(row - 1, 0) if quarter == 1 else min(row + 1, rows - 1)
                blend_rows(line, x, table, level + 1, channels, channel, row, far_row, low - 2)
                if low == 0:
                    line[1] = line[2]
                if low + n >= cols:
                    line[cols - low + 2] = line[cols - low + 1]
                here, beside = line[2 : 2 + n], line[5 - 2 * quarter : 5 - 2 * quarter + n]
                o = offset + quarter * size + (row + 1) * stride + low
                w = weight[o : o + n]
                o += (channels - 1) * offset + 4 * channel * size
                own = x[o : o + n]
                for i in range(n):
                    change = near * here[i] + far * beside[i] if w[i] > zero else zero
                    largest = max(largest, bits_of(change))
                    own[i] += change
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
    x, b, weight, diagonal, edge_e, edge_s, band, cells, scratch, scratch64, runs, segments, table, steps, channels
):
    """Runs the steps of a cycle, (n, 2) int64: what to do, and on which level.

    Returns the bit patterns of the largest change that the finest level saw: by the sweep before, by the
    coarse correction and by the sweep after.  Their sum bounds the change of any black cell in this cycle.
    """
    before = correction = after = np.int32(0)
    for k in range(steps.shape[0]):
        step, level = steps[k, 0], steps[k, 1]
        rows = table[level, ROWS]
        if step == COARSEST:
            change = solve_coarsest(x, b, band, cells, scratch64, table, level, channels)
            if level == 0:
                correction = change
            continue
        if step == UP:
            change = prolong(x, weight, scratch, runs, table, level, channels, 0, rows)
            if level == 0:
                correction = change
        if level == 0:
            relax_finest(x, b, weight, runs, table, channels, RED, 0, rows)
            change = relax_finest(x, b, weight, runs, table, channels, BLACK, 0, rows)
            if step == DOWN:
                before = change
            else:
                after = change
        else:
            relax_coarse(x, b, weight, edge_e, edge_s, scratch, segments, table, level, channels, RED)
            relax_coarse(x, b, weight, edge_e, edge_s, scratch, segments, table, level, channels, BLACK)
        if step == DOWN:
            restrict_residual(x, b, weight, diagonal, edge_e, edge_s, scratch, runs, table, level, channels, 0, rows)
    return before, correction, after
