"""Every compiled kernel, and nothing else.

`layout` says where a value lies; the names here are the same: `low`, `high` bound a run, `half` is a row's length per
colour.  Arguments come in one order: what is written first, then what is read, then scalars.  Kernels validate
nothing, allocate nothing and raise nothing.  They take ranges of rows, so that a caller can give bands of rows to
several threads: a half sweep reads only the other colour, hence any split gives the same bits.

Rows are taken as slices ``v = X[o : o + n]`` and indexed by the plain loop variable: with a signed offset inside the
index (``X[o + i]``) numba adds a wrap-around test to each access and LLVM no longer vectorises the loop.

LLVM also gives up a loop whose arrays need more than eight overlap tests.  Loops that read many arrays are
therefore cut in two, with a row of `scratch` in between that stays in the first-level cache.

A kernel that reports the largest change compares the bit patterns of absolute values as integers: that order is the
order of the values, NaN and infinity stand above everything, so neither can hide, and it vectorises without
`fastmath`.
"""

import numpy as np
from numba import njit

from solvers.layout import HALF, HEIGHT, OFFSET, ROWS, STRIDE, WIDTH

# The one jit policy.  On disk: the first use compiles, later processes load.  Without the GIL: callers use threads.
# No fastmath: a NaN must be seen.  Division by zero follows IEEE, as in numpy.
jit = njit(cache=True, nogil=True, error_model="numpy", boundscheck=False)

ABS_BITS = np.int32(0x7FFFFFFF)  # all but the sign of a float32

LEAK_CAP = np.float32(4.0)  # conductance of a known value a quarter of a cell away

DOWN, UP, COARSEST = 0, 1, 2  # the steps of a cycle, see cycles.py

RED, BLACK = 0, 1


# --- set-up: the region and its runs -----------------------------------------------------------------------------


@jit
def find_runs(runs, run_start, region, gap):
    """Runs of the finest level; returns their number.

    runs: (>= n, 2) int32, written; pass an array of no rows to count only.  run_start: (height + 1,) int64, written.
    region: (height, width) bool.  gap: stretches with fewer empty indices between them become one run.
    """
    height, width = region.shape
    half = (width + 1) // 2
    count = 0
    write = runs.shape[0] > 0
    for row in range(height):
        run_start[row] = count
        line = region[row]
        low = high = -1  # the open run
        for i in range(half):
            if line[2 * i] or (2 * i + 1 < width and line[2 * i + 1]):
                if high >= 0 and i - high >= gap:
                    if write:
                        runs[count, 0], runs[count, 1] = low, high
                    count += 1
                    low = i
                elif high < 0:
                    low = i
                high = i + 1
        if high >= 0:
            if write:
                runs[count, 0], runs[count, 1] = low, high
            count += 1
    run_start[height] = count
    return count


@jit
def coarsen_runs(runs, run_start, fine_runs, fine_start, height, gap):
    """Runs of the next coarser level: those of each pair of fine rows united, at half the index.

    runs: (n fine runs, 2) int32, written; run_start: (coarse height + 1,) int64, written; height: the fine one.
    """
    count = 0
    for coarse_row in range((height + 1) // 2):
        run_start[coarse_row] = count
        a, a_end = fine_start[2 * coarse_row], fine_start[2 * coarse_row + 1]
        b = a_end
        b_end = fine_start[2 * coarse_row + 2] if 2 * coarse_row + 2 <= height else b
        low = high = -1
        while a < a_end or b < b_end:
            if b >= b_end or (a < a_end and fine_runs[a, 0] <= fine_runs[b, 0]):
                k = a
                a += 1
            else:
                k = b
                b += 1
            next_low, next_high = fine_runs[k, 0] // 2, (fine_runs[k, 1] + 1) // 2
            if high >= 0 and next_low - high >= gap:
                runs[count, 0], runs[count, 1] = low, high
                count += 1
                low, high = next_low, next_high
            elif high < 0:
                low, high = next_low, next_high
            else:
                high = max(high, next_high)
        if high >= 0:
            runs[count, 0], runs[count, 1] = low, high
            count += 1
    run_start[(height + 1) // 2] = count
    return count


@jit
def split_region(weight, diagonal, region, runs, run_start, table):
    """The finest level's coefficients: diagonal = |N_p|, weight = 1 / |N_p| in the region, both 0 outside it."""
    height, width, stride = table[0, HEIGHT], table[0, WIDTH], table[0, STRIDE]
    for row in range(height):
        rows_beside = np.int64(row > 0) + np.int64(row < height - 1)
        for colour in range(2):
            shift = (row + colour) & 1
            start = (row + 1) * 2 * stride + colour * stride
            for k in range(run_start[row], run_start[row + 1]):
                for i in range(runs[k, 0], runs[k, 1]):
                    col = 2 * i + shift
                    if col < width and region[row, col]:
                        neighbours = rows_beside + np.int64(col > 0) + np.int64(col < width - 1)
                        diagonal[start + i] = neighbours
                        weight[start + i] = np.float32(1.0) / np.float32(neighbours)


# --- set-up: the hierarchy.  Grids here are plain (rows, columns), padded to even sides ----------------------------


@jit
def half_conductance(w):
    """A fine edge that crosses between two coarse cells, whose centres lie twice as far apart: w in series with 1."""
    return w / (np.float32(1.0) + w)


@jit
def moved_leak(g, quarters):
    """The conductance to the same known value from a centre that lies `quarters`/4 of a cell further away."""
    return g / max(np.float32(1.0) + np.float32(0.25) * quarters * g, g / LEAK_CAP)


@jit
def conductances_of_region(edge_e, edge_s, leak, region):
    """Conductances of the finest level, all 0 or 1.

    edge_e, edge_s: (>= height, >= width) float32 zeros, written: to the east and south neighbour, both unknown.
    leak: (4, >= height, >= width) float32 zeros, written: to a known pixel in the north, south, west, east.
    """
    height, width = region.shape
    one = np.float32(1.0)
    for row in range(height):
        for col in range(width):
            if not region[row, col]:
                continue
            if row > 0 and not region[row - 1, col]:
                leak[0, row, col] = one
            if row < height - 1:
                if region[row + 1, col]:
                    edge_s[row, col] = one
                else:
                    leak[1, row, col] = one
            if col > 0 and not region[row, col - 1]:
                leak[2, row, col] = one
            if col < width - 1:
                if region[row, col + 1]:
                    edge_e[row, col] = one
                else:
                    leak[3, row, col] = one


@jit
def coarsen(coarse_e, coarse_s, coarse_leak, edge_e, edge_s, leak, runs, run_start, coarse_height, coarse_width):
    """2 x 2 aggregation of the conductances, one leak per direction: a known value keeps its distance.

    The coarse arrays are float32 zeros and are written on the runs of the coarse level.  The fine ones have even sides.
    """
    plus, minus = np.float32(1.0), np.float32(-1.0)
    for row in range(coarse_height):
        n, s = 2 * row, 2 * row + 1
        for k in range(run_start[row], run_start[row + 1]):
            for col in range(2 * runs[k, 0], min(2 * runs[k, 1], coarse_width)):
                w, e = 2 * col, 2 * col + 1
                coarse_e[row, col] = half_conductance(edge_e[n, e]) + half_conductance(edge_e[s, e])
                coarse_s[row, col] = half_conductance(edge_s[s, w]) + half_conductance(edge_s[s, e])
                # The children beside the known value move away from it when they merge, the others towards it.
                coarse_leak[0, row, col] = (
                    moved_leak(leak[0, n, w], plus)
                    + moved_leak(leak[0, n, e], plus)
                    + moved_leak(leak[0, s, w], minus)
                    + moved_leak(leak[0, s, e], minus)
                )
                coarse_leak[1, row, col] = (
                    moved_leak(leak[1, s, w], plus)
                    + moved_leak(leak[1, s, e], plus)
                    + moved_leak(leak[1, n, w], minus)
                    + moved_leak(leak[1, n, e], minus)
                )
                coarse_leak[2, row, col] = (
                    moved_leak(leak[2, n, w], plus)
                    + moved_leak(leak[2, s, w], plus)
                    + moved_leak(leak[2, n, e], minus)
                    + moved_leak(leak[2, s, e], minus)
                )
                coarse_leak[3, row, col] = (
                    moved_leak(leak[3, n, e], plus)
                    + moved_leak(leak[3, s, e], plus)
                    + moved_leak(leak[3, n, w], minus)
                    + moved_leak(leak[3, s, w], minus)
                )


@jit
def split_conductances(weight, diagonal, split_e, split_s, edge_e, edge_s, leak, runs, run_start, table, level):
    """One coarse level's conductances into the layout; diagonal = their sum over a cell, weight = 1 / diagonal."""
    height, width, stride = table[level, HEIGHT], table[level, WIDTH], table[level, STRIDE]
    offset, skip, first = table[level, OFFSET], table[1, OFFSET], table[level, ROWS]
    for row in range(height):
        for colour in range(2):
            shift = (row + colour) & 1
            start = offset + (row + 1) * 2 * stride + colour * stride
            for k in range(run_start[first + row], run_start[first + row + 1]):
                for i in range(runs[k, 0], runs[k, 1]):
                    col = 2 * i + shift
                    if col >= width:
                        continue
                    total = leak[0, row, col] + leak[1, row, col] + leak[2, row, col] + leak[3, row, col]
                    total += edge_e[row, col] + edge_s[row, col]
                    if col > 0:
                        total += edge_e[row, col - 1]
                    if row > 0:
                        total += edge_s[row - 1, col]
                    if total > 0:
                        diagonal[start + i] = total
                        weight[start + i] = np.float32(1.0) / total
                        split_e[start - skip + i] = edge_e[row, col]
                        split_s[start - skip + i] = edge_s[row, col]


@jit
def factor_band(band):
    """Cholesky factor of a symmetric positive definite band matrix, in place.

    band: (n, bandwidth + 1) float64, band[i, k] = A[i, i - k]; on return the same of L with A = L L^T.
    """
    n, bandwidth = band.shape[0], band.shape[1] - 1
    for i in range(n):
        for k in range(min(i, bandwidth), 0, -1):
            j = i - k
            total = band[i, k]
            for m in range(1, min(bandwidth - k, j) + 1):
                total -= band[i, k + m] * band[j, m]
            band[i, k] = total / band[j, 0]
        total = band[i, 0]
        for m in range(1, min(bandwidth, i) + 1):
            total -= band[i, m] * band[i, m]
        band[i, 0] = np.sqrt(total)


# --- one level of a cycle ----------------------------------------------------------------------------------------


@jit
def largest_bits(a, b):
    return a if a > b else b


@jit
def bits_of(value):
    """The bit pattern of |value|: as integers these order like the values, with NaN on top."""
    return np.float32(value).view(np.int32) & ABS_BITS


@jit
def relax_finest(x, b, weight, runs, run_start, table, channels, colour, first_row, end_row):
    """Gauss-Seidel half sweep over one colour of rows [first_row, end_row) of the finest level.

    Returns the bit pattern of the largest absolute change.
    """
    stride = table[0, STRIDE]
    pitch = 2 * stride * channels
    largest = np.int32(0)
    for row in range(first_row, end_row):
        beside = 1 if (row + colour) & 1 else -1
        for k in range(run_start[row], run_start[row + 1]):
            low = np.int64(runs[k, 0])
            n = np.int64(runs[k, 1]) - low
            at = (row + 1) * 2 * stride + colour * stride + low
            w = weight[at : at + n]
            for channel in range(channels):
                own_at = ((row + 1) * channels + channel) * 2 * stride + colour * stride + low
                at = own_at + (1 - 2 * colour) * stride
                own, rhs = x[own_at : own_at + n], b[own_at : own_at + n]
                north, south = x[at - pitch : at - pitch + n], x[at + pitch : at + pitch + n]
                same, next_ = x[at : at + n], x[at + beside : at + beside + n]
                for i in range(n):
                    new = w[i] * (rhs[i] + north[i] + south[i] + same[i] + next_[i])
                    largest = max(largest, bits_of(new - own[i]))
                    own[i] = new
    return largest


@jit
def relax_over(x, b, weight, runs, run_start, table, channels, colour, omega, first_row, end_row):
    """Like `relax_finest`, but every change is multiplied by the relaxation factor `omega` (float32)."""
    stride = table[0, STRIDE]
    pitch = 2 * stride * channels
    largest = np.int32(0)
    for row in range(first_row, end_row):
        beside = 1 if (row + colour) & 1 else -1
        for k in range(run_start[row], run_start[row + 1]):
            low = np.int64(runs[k, 0])
            n = np.int64(runs[k, 1]) - low
            at = (row + 1) * 2 * stride + colour * stride + low
            w = weight[at : at + n]
            for channel in range(channels):
                own_at = ((row + 1) * channels + channel) * 2 * stride + colour * stride + low
                at = own_at + (1 - 2 * colour) * stride
                own, rhs = x[own_at : own_at + n], b[own_at : own_at + n]
                north, south = x[at - pitch : at - pitch + n], x[at + pitch : at + pitch + n]
                same, next_ = x[at : at + n], x[at + beside : at + beside + n]
                for i in range(n):
                    change = omega * (w[i] * (rhs[i] + north[i] + south[i] + same[i] + next_[i]) - own[i])
                    largest = max(largest, bits_of(change))
                    own[i] += change
    return largest


@jit
def relax_coarse(x, b, weight, edge_e, edge_s, scratch, runs, run_start, table, level, channels, colour):
    """Gauss-Seidel half sweep over one colour of a coarse level."""
    height, stride, offset = table[level, HEIGHT], table[level, STRIDE], table[level, OFFSET]
    first, edges = table[level, ROWS], table[level, OFFSET] - table[1, OFFSET]
    pitch = 2 * stride * channels
    for row in range(height):
        odd = (row + colour) & 1
        for k in range(run_start[first + row], run_start[first + row + 1]):
            low = np.int64(runs[k, 0])
            n = np.int64(runs[k, 1]) - low
            at = (row + 1) * 2 * stride + colour * stride + low
            w = weight[offset + at : offset + at + n]
            c_south = edge_s[edges + at : edges + at + n]
            c_east = edge_e[edges + at : edges + at + n]
            at += (1 - 2 * colour) * stride  # the neighbours' side of an edge
            c_north = edge_s[edges + at - 2 * stride : edges + at - 2 * stride + n]
            c_west = edge_e[edges + at - 1 + odd : edges + at - 1 + odd + n]
            total = scratch[:n]
            for channel in range(channels):
                own_at = channels * offset + ((row + 1) * channels + channel) * 2 * stride + colour * stride + low
                at = own_at + (1 - 2 * colour) * stride
                own, rhs = x[own_at : own_at + n], b[own_at : own_at + n]
                north, south = x[at - pitch : at - pitch + n], x[at + pitch : at + pitch + n]
                west, east = x[at - 1 + odd : at - 1 + odd + n], x[at + odd : at + odd + n]
                for i in range(n):
                    total[i] = rhs[i] + c_north[i] * north[i] + c_south[i] * south[i]
                for i in range(n):
                    own[i] = w[i] * (total[i] + c_west[i] * west[i] + c_east[i] * east[i])


@jit
def add_red_residual(
    total, scratch, x, b, weight, diagonal, edge_e, edge_s, table, level, channels, channel, row, low, n
):
    """total[:n] += residual of the red cells [low, low + n) of one row."""
    stride, offset = table[level, STRIDE], table[level, OFFSET]
    edges = offset - table[1, OFFSET]
    pitch = 2 * stride * channels
    odd = row & 1
    at = (row + 1) * 2 * stride + low
    d = diagonal[offset + at : offset + at + n]
    own_at = channels * offset + ((row + 1) * channels + channel) * 2 * stride + low
    own, rhs = x[own_at : own_at + n], b[own_at : own_at + n]
    there = own_at + stride
    north, south = x[there - pitch : there - pitch + n], x[there + pitch : there + pitch + n]
    west, east = x[there - 1 + odd : there - 1 + odd + n], x[there + odd : there + odd + n]
    if level == 0:
        w = weight[at : at + n]  # zero outside the region, where the sum below means nothing
        for i in range(n):
            total[i] += d[i] * (w[i] * (rhs[i] + north[i] + south[i] + west[i] + east[i]) - own[i])
        return
    c_south = edge_s[edges + at : edges + at + n]
    c_east = edge_e[edges + at : edges + at + n]
    at += stride
    c_north = edge_s[edges + at - 2 * stride : edges + at - 2 * stride + n]
    c_west = edge_e[edges + at - 1 + odd : edges + at - 1 + odd + n]
    sum_ = scratch[:n]
    for i in range(n):
        sum_[i] = rhs[i] - d[i] * own[i] + c_north[i] * north[i]
    for i in range(n):
        sum_[i] += c_south[i] * south[i] + c_east[i] * east[i]
    for i in range(n):
        total[i] += sum_[i] + c_west[i] * west[i]


@jit
def restrict_residual(
    x, b, weight, diagonal, edge_e, edge_s, scratch, runs, run_start, table, level, channels, first_row, end_row
):
    """Right-hand side of coarse rows [first_row, end_row) of level + 1: the sum of the children's residuals.

    Zeroes the coarse unknowns too.  A black half sweep must have come before: black residuals are then zero, and only
    the red ones are computed.  scratch: two rows of the finest level.
    """
    coarse = level + 1
    stride, offset, first = table[coarse, STRIDE], table[coarse, OFFSET], table[coarse, ROWS]
    height, half = table[level, HEIGHT], table[level, HALF]
    middle = scratch.shape[0] // 2
    for row in range(first_row, end_row):
        even = row & 1  # the colour of the coarse cells in even columns
        for k in range(run_start[first + row], run_start[first + row + 1]):
            low, high = np.int64(runs[k, 0]), np.int64(runs[k, 1])
            n = high - low
            fine_n = min(2 * high, half) - 2 * low
            total = scratch[: 2 * n]
            for channel in range(channels):
                for i in range(2 * n):
                    total[i] = 0
                for fine_row in range(2 * row, min(2 * row + 2, height)):
                    add_red_residual(
                        total,
                        scratch[middle:],
                        x,
                        b,
                        weight,
                        diagonal,
                        edge_e,
                        edge_s,
                        table,
                        level,
                        channels,
                        channel,
                        fine_row,
                        2 * low,
                        fine_n,
                    )
                at = channels * offset + ((row + 1) * channels + channel) * 2 * stride + low
                even_at, odd_at = at + even * stride, at + (1 - even) * stride
                b_even, b_odd = b[even_at : even_at + n], b[odd_at : odd_at + n]
                x_even, x_odd = x[even_at : even_at + n], x[odd_at : odd_at + n]
                for i in range(n):
                    b_even[i] = total[2 * i]
                    b_odd[i] = total[2 * i + 1]
                for i in range(n):
                    x_even[i] = 0
                    x_odd[i] = 0


@jit
def prolong(x, weight, scratch, runs, run_start, table, level, channels, first_row, end_row):
    """Adds the 9-3-3-1 interpolation of level + 1 to the black cells of rows [first_row, end_row).

    Only black ones: the next half sweep overwrites the red ones without reading them.  An inactive coarse cell counts
    as 0, and the grid continues with its edge.  Returns the bit pattern of the largest absolute change.
    """
    coarse = level + 1
    stride, offset, first = table[level, STRIDE], table[level, OFFSET], table[level, ROWS]
    coarse_height, coarse_width = table[coarse, HEIGHT], table[coarse, WIDTH]
    coarse_stride = table[coarse, STRIDE]
    near, far = np.float32(0.75), np.float32(0.25)
    zero = np.float32(0.0)
    largest = np.int32(0)
    for row in range(first_row, end_row):
        near_row = row >> 1
        far_row = min(max(near_row - 1 + 2 * (row & 1), 0), coarse_height - 1)
        beside = -1 if row & 1 else 1  # black cells of even rows stand in odd columns
        for k in range(run_start[first + row], run_start[first + row + 1]):
            low, high = np.int64(runs[k, 0]), np.int64(runs[k, 1])
            n = high - low
            at = offset + (row + 1) * 2 * stride + stride + low
            w = weight[at : at + n]
            pairs = ((low - 1) >> 1, (high >> 1) + 1)  # coarse indices whose cells cover columns low - 1 ... high
            m = pairs[1] - pairs[0]
            left = low - 2 * pairs[0]  # column `low` in the row that is put together below
            for channel in range(channels):
                line = channels * table[coarse, OFFSET] + channel * 2 * coarse_stride + pairs[0]
                near_at = line + (near_row + 1) * channels * 2 * coarse_stride
                far_at = line + (far_row + 1) * channels * 2 * coarse_stride
                a = near_at + (near_row & 1) * coarse_stride
                near_even = x[a : a + m]
                a = near_at + (1 - (near_row & 1)) * coarse_stride
                near_odd = x[a : a + m]
                a = far_at + (far_row & 1) * coarse_stride
                far_even = x[a : a + m]
                a = far_at + (1 - (far_row & 1)) * coarse_stride
                far_odd = x[a : a + m]
                line_of = scratch[: 2 * m]
                for i in range(m):
                    line_of[2 * i] = near * near_even[i] + far * far_even[i]
                    line_of[2 * i + 1] = near * near_odd[i] + far * far_odd[i]
                if low == 0:
                    line_of[left - 1] = line_of[left]
                if high == coarse_width:
                    line_of[left + n] = line_of[left + n - 1]
                here = scratch[left : left + n]
                side = scratch[left + beside : left + beside + n]
                at = channels * offset + ((row + 1) * channels + channel) * 2 * stride + stride + low
                own = x[at : at + n]
                for i in range(n):
                    change = near * here[i] + far * side[i] if w[i] > zero else zero
                    largest = max(largest, bits_of(change))
                    own[i] += change
    return largest


@jit
def solve_coarsest(x, b, band, cell_row, cell_index, scratch64, table, level, channels):
    """x = A^-1 b on the coarsest level, by its Cholesky factor; returns the bit pattern of the largest change.

    band: (n, bandwidth + 1) float64 from `factor_band`.  cell_row, cell_index: (n,) int64, a cell's row and its
    position in that row's pair of colours.  scratch64: (n,) float64.
    """
    stride, offset = table[level, STRIDE], table[level, OFFSET]
    n, bandwidth = band.shape[0], band.shape[1] - 1
    largest = np.int32(0)
    for channel in range(channels):
        for i in range(n):
            at = channels * offset + ((cell_row[i] + 1) * channels + channel) * 2 * stride + cell_index[i]
            total = np.float64(b[at])
            for k in range(1, min(bandwidth, i) + 1):
                total -= band[i, k] * scratch64[i - k]
            scratch64[i] = total / band[i, 0]
        for i in range(n - 1, -1, -1):
            total = scratch64[i]
            for k in range(1, min(bandwidth, n - 1 - i) + 1):
                total -= band[i + k, k] * scratch64[i + k]
            scratch64[i] = total / band[i, 0]
            at = channels * offset + ((cell_row[i] + 1) * channels + channel) * 2 * stride + cell_index[i]
            new = np.float32(scratch64[i])
            largest = max(largest, bits_of(new - x[at]))
            x[at] = new
    return largest


@jit
def run_steps(
    x, b, weight, diagonal, edge_e, edge_s, band, cell_row, cell_index, scratch, scratch64,
    runs, run_start, table, steps, channels,
):  # fmt: skip
    """Runs the steps of a cycle, (n, 2) int64: what to do, and on which level.

    Returns the bit patterns of the largest change that the finest level saw: by the sweep before, by the
    coarse correction and by the sweep after.  Their sum bounds the change of any black cell in this cycle.
    """
    before = correction = after = np.int32(0)
    for k in range(steps.shape[0]):
        step, level = steps[k, 0], steps[k, 1]
        height = table[level, HEIGHT]
        if step == COARSEST:
            change = solve_coarsest(x, b, band, cell_row, cell_index, scratch64, table, level, channels)
            if level == 0:
                correction = change
            continue
        if step == UP:
            change = prolong(x, weight, scratch, runs, run_start, table, level, channels, 0, height)
            if level == 0:
                correction = change
        if level == 0:
            relax_finest(x, b, weight, runs, run_start, table, channels, RED, 0, height)
            change = relax_finest(x, b, weight, runs, run_start, table, channels, BLACK, 0, height)
            if step == DOWN:
                before = change
            else:
                after = change
        else:
            relax_coarse(x, b, weight, edge_e, edge_s, scratch, runs, run_start, table, level, channels, RED)
            relax_coarse(x, b, weight, edge_e, edge_s, scratch, runs, run_start, table, level, channels, BLACK)
        if step == DOWN:
            restrict_residual(
                x, b, weight, diagonal, edge_e, edge_s, scratch, runs, run_start, table, level, channels,
                0, table[level + 1, HEIGHT],
            )  # fmt: skip
    return before, correction, after


# --- between pictures and the layout, and between float32 and float64 ---------------------------------------------


@jit
def assemble(b, values, across, down, rhs, total, region, runs, run_start, table):
    """b = the residual of the problem at f + total, summed in float64: rhs_p + sum over q of v_pq - (f_p - f_q).

    values: (height, width, channels) f, known outside the region, first guess inside.  across, down: v on pixel pairs
    (`Guidance`); rhs: like values; arrays without rows stand for zeros.  total: a correction already found, float32.

    Returns whether float32 held every value of b exactly.
    """
    height, width, channels = values.shape
    stride = table[0, STRIDE]
    pitch = 2 * stride * channels
    guided, given = across.shape[0] > 0 or down.shape[0] > 0, rhs.shape[0] > 0
    exact = True
    for row in range(height):
        for k in range(run_start[row], run_start[row + 1]):
            for col in range(2 * runs[k, 0], min(2 * runs[k, 1], width)):
                if not region[row, col]:
                    continue
                colour = (row + col) & 1
                at = (row + 1) * pitch + colour * stride + (col >> 1)
                there = at + (1 - 2 * colour) * stride
                east = (row + colour) & 1  # whether the neighbour at the same index is the west or the east one
                for channel in range(channels):
                    here = np.float64(values[row, col, channel]) + total[at]
                    sum_ = 0.0
                    if given:
                        sum_ += rhs[row, col, channel]
                    if col > 0:
                        sum_ += (values[row, col - 1, channel] + np.float64(total[there - 1 + east])) - here
                        if guided:
                            sum_ -= across[row, col - 1, channel]
                    if col < width - 1:
                        sum_ += (values[row, col + 1, channel] + np.float64(total[there + east])) - here
                        if guided:
                            sum_ += across[row, col, channel]
                    if row > 0:
                        sum_ += (values[row - 1, col, channel] + np.float64(total[there - pitch])) - here
                        if guided:
                            sum_ -= down[row - 1, col, channel]
                    if row < height - 1:
                        sum_ += (values[row + 1, col, channel] + np.float64(total[there + pitch])) - here
                        if guided:
                            sum_ += down[row, col, channel]
                    b[at] = sum_
                    exact &= np.float64(b[at]) == sum_
                    at += 2 * stride
                    there += 2 * stride
    return exact


@jit
def add_solution(solution, total, x, region, runs, run_start, table):
    """solution += total + x, summed in float64, on the region; solution: (height, width, channels)."""
    height, width, channels = solution.shape
    stride = table[0, STRIDE]
    for row in range(height):
        for k in range(run_start[row], run_start[row + 1]):
            for col in range(2 * runs[k, 0], min(2 * runs[k, 1], width)):
                if region[row, col]:
                    at = (row + 1) * channels * 2 * stride + ((row + col) & 1) * stride + (col >> 1)
                    for channel in range(channels):
                        u = np.float64(total[at + channel * 2 * stride]) + x[at + channel * 2 * stride]
                        if u != 0.0:  # so that an unchanged -0.0 keeps its sign
                            solution[row, col, channel] += u


@jit
def fold(total, x, runs, run_start, table, channels):
    """total += x, in float32; x becomes what was really added, so that the residual can follow it exactly."""
    stride = table[0, STRIDE]
    for row in range(table[0, HEIGHT]):
        for k in range(run_start[row], run_start[row + 1]):
            n = np.int64(runs[k, 1]) - runs[k, 0]
            for line in range(2 * channels):
                at = ((row + 1) * channels * 2 + line) * stride + runs[k, 0]
                t, own = total[at : at + n], x[at : at + n]
                for i in range(n):
                    new = t[i] + own[i]
                    own[i] = new - t[i]
                    t[i] = new


@jit
def subtract_image(b, x, weight, diagonal, runs, run_start, table, channels, keep):
    """b - A x on the finest level, in float64; stored into b unless `keep`.  Returns the largest absolute value."""
    stride = table[0, STRIDE]
    pitch = 2 * stride * channels
    largest = 0.0
    for row in range(table[0, HEIGHT]):
        for k in range(run_start[row], run_start[row + 1]):
            low = np.int64(runs[k, 0])
            n = np.int64(runs[k, 1]) - low
            for colour in range(2):
                beside = 1 if (row + colour) & 1 else -1
                at = (row + 1) * 2 * stride + colour * stride + low
                w, d = weight[at : at + n], diagonal[at : at + n]
                for channel in range(channels):
                    own_at = ((row + 1) * channels + channel) * 2 * stride + colour * stride + low
                    at = own_at + (1 - 2 * colour) * stride
                    own, rhs = x[own_at : own_at + n], b[own_at : own_at + n]
                    north, south = x[at - pitch : at - pitch + n], x[at + pitch : at + pitch + n]
                    same, next_ = x[at : at + n], x[at + beside : at + beside + n]
                    for i in range(n):
                        around = (np.float64(north[i]) + south[i]) + (np.float64(same[i]) + next_[i])
                        r = rhs[i] - (np.float64(d[i]) * own[i] - around) if w[i] > 0 else 0.0
                        if not abs(r) <= largest:  # a NaN comes through
                            largest = abs(r)
                        if not keep:
                            rhs[i] = r
    return largest


@jit
def largest_value(x, runs, run_start, table, channels):
    """The bit pattern of the largest absolute value on the finest level."""
    stride = table[0, STRIDE]
    largest = np.int32(0)
    for row in range(table[0, HEIGHT]):
        for k in range(run_start[row], run_start[row + 1]):
            n = np.int64(runs[k, 1]) - runs[k, 0]
            for line in range(2 * channels):
                at = ((row + 1) * channels * 2 + line) * stride + runs[k, 0]
                own = x[at : at + n]
                for i in range(n):
                    largest = max(largest, bits_of(own[i]))
    return largest
