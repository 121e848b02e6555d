"""From a region to the runs and coefficients of all levels; see `solvers.hierarchy` for what they mean."""

import numpy as np

from solvers.kernels.policy import jit
from solvers.layout import COLS, HEIGHT, OFFSET, QUARTER, STRIDE, WIDTH

LEAK_CAP = np.float32(4.0)  # conductance of a known value a quarter of a cell away


# --- runs --------------------------------------------------------------------------------------------------------


@jit
def find_runs(runs, region, gap):
    """Runs of the finest level; returns their number.

    runs: (n, 3) int32, written as far as it goes: pass one without rows to count only.  region: (height, width) bool.
    gap: stretches with fewer empty places between them become one run.
    """
    height, width = region.shape
    cols = (width + 1) // 2
    room = runs.shape[0]
    count = 0
    for row in range((height + 1) // 2):
        upper = region[2 * row]
        lower = region[min(2 * row + 1, height - 1)]
        low = high = -1  # the open run
        for col in range(cols):
            left, right = 2 * col, min(2 * col + 1, width - 1)
            if upper[left] | upper[right] | lower[left] | lower[right]:
                if high >= 0 and col - high >= gap:
                    if count < room:
                        runs[count, 0], runs[count, 1], runs[count, 2] = row, low, high
                    count += 1
                    low = col
                elif high < 0:
                    low = col
                high = col + 1
        if high >= 0:
            if count < room:
                runs[count, 0], runs[count, 1], runs[count, 2] = row, low, high
            count += 1
    return count


@jit
def coarsen_runs(runs, fine, gap):
    """Runs of the next coarser level: those of each pair of rows united, at half the column; returns their number.

    runs: (at least as many as fine, 3) int32, written.
    """
    count = 0
    n = fine.shape[0]
    k = 0
    while k < n:
        row = fine[k, 0] // 2
        a = k  # the upper row's runs are a ... a_end, the lower one's b ... b_end
        while k < n and fine[k, 0] == 2 * row:
            k += 1
        a_end = b = k
        while k < n and fine[k, 0] == 2 * row + 1:
            k += 1
        b_end = k
        low = high = -1
        while a < a_end or b < b_end:
            if b >= b_end or (a < a_end and fine[a, 1] <= fine[b, 1]):
                at = a
                a += 1
            else:
                at = b
                b += 1
            next_low, next_high = fine[at, 1] // 2, (fine[at, 2] + 1) // 2
            if high < 0:
                low, high = next_low, next_high
            elif next_low - high >= gap:
                runs[count, 0], runs[count, 1], runs[count, 2] = row, low, high
                count += 1
                low, high = next_low, next_high
            else:
                high = max(high, next_high)
        runs[count, 0], runs[count, 1], runs[count, 2] = row, low, high
        count += 1
    return count


@jit
def join_runs(segments, runs, stride, first_run, gap, longest):
    """Segments of a level from its runs; returns their number.

    segments: (n, 4) int64, written as far as it goes.  gap: runs with fewer places between them are joined, unless the
    segment would grow beyond `longest`.  first_run: number of the level's first run.
    """
    room = segments.shape[0]
    count = 0
    start = end = np.int64(-1)
    first = 0
    for k in range(runs.shape[0] + 1):
        low = high = np.int64(0)
        if k < runs.shape[0]:
            low = (np.int64(runs[k, 0]) + 1) * stride + runs[k, 1]
            high = low + runs[k, 2] - runs[k, 1]
            if start >= 0 and low - end < gap and high - start <= longest:
                end = high
                continue
        if start >= 0:
            if count < room:
                segments[count, 0], segments[count, 1] = start, end
                segments[count, 2], segments[count, 3] = first_run + first, first_run + k
            count += 1
        start, end, first = low, high, k
    return count


# --- coefficients ------------------------------------------------------------------------------------------------


@jit
def weigh_region(weight, diagonal, region, runs, table):
    """The finest level's coefficients: diagonal = |N_p|, weight = 1 / |N_p| in the region, both 0 outside it."""
    height, width = table[0, HEIGHT], table[0, WIDTH]
    stride, size = table[0, STRIDE], table[0, QUARTER]
    four, quarter_of_one = np.float32(4.0), np.float32(0.25)
    for k in range(runs.shape[0]):
        row, low = np.int64(runs[k, 0]), np.int64(runs[k, 1])
        for quarter in range(4):
            pixel_row = 2 * row + (quarter >> 1)
            if pixel_row >= height:
                continue
            first = 2 * low + (quarter & 1)
            n = min(np.int64(runs[k, 2]) - low, (width - first + 1) // 2)
            at = quarter * size + (row + 1) * stride + low
            w, d, line = weight[at : at + n], diagonal[at : at + n], region[pixel_row, first:]
            for i in range(n):
                w[i] = quarter_of_one if line[2 * i] else np.float32(0.0)
                d[i] = four if line[2 * i] else np.float32(0.0)
            beside = np.int64(pixel_row > 0) + np.int64(pixel_row < height - 1)
            edge_row = beside < 2
            for i in range(n):  # pixels at the edge of the image have fewer neighbours
                col = first + 2 * i
                if (edge_row or col == 0 or col == width - 1) and line[2 * i]:
                    neighbours = beside + np.int64(col > 0) + np.int64(col < width - 1)
                    d[i] = neighbours
                    w[i] = np.float32(1.0) / np.float32(neighbours)


@jit
def half_conductance(w):
    """A fine edge that crosses between two coarse cells, whose centres lie twice as far apart: w in series with 1."""
    return w / (np.float32(1.0) + w)


@jit
def moved_away(g):
    """The conductance to the same known value from a centre that lies a quarter of a coarse cell further away."""
    return g / max(np.float32(1.0) + np.float32(0.25) * g, g / LEAK_CAP)


@jit
def moved_near(g):
    """The same from a quarter of a coarse cell nearer."""
    return g / max(np.float32(1.0) - np.float32(0.25) * g, g / LEAK_CAP)


@jit
def mark_unknown(marks, weight, at):
    """marks = 1 where the weight is positive, else 0."""
    w = weight[at : at + marks.shape[0]]
    for i in range(marks.shape[0]):
        marks[i] = np.float32(1.0) if w[i] > 0 else np.float32(0.0)


@jit
def scatter_row(coarse, scratch, at, size, n):
    """A row of coarse cells into their quarters: even columns into the one that holds `at`, odd ones into the next."""
    even, odd = coarse[at : at + n // 2], coarse[at + size : at + size + n // 2]
    for i in range(n // 2):
        even[i] = scratch[2 * i]
        odd[i] = scratch[2 * i + 1]


@jit
def coarsen_region(edge_e, edge_s, leak_n, leak_s, leak_w, leak_e, scratch, weight, runs, table):
    """Conductances of level 1 from the region: `coarsen` with all fine conductances 0 or 1.

    The six fields begin at level 1 and hold zeros; they are written at the places of the finest level's `runs`, which
    are the cells of level 1.  weight: the finest level's, positive where unknown.  scratch: 13 of its rows.
    """
    height, width, cols = table[0, HEIGHT], table[0, WIDTH], table[0, COLS]
    stride, size = table[0, STRIDE], table[0, QUARTER]
    coarse_stride, coarse_size = table[1, STRIDE], table[1, QUARTER]
    one, zero = np.float32(1.0), np.float32(0.0)
    half, away, near = half_conductance(one), moved_away(one), moved_near(one)
    for k in range(runs.shape[0]):
        row, low = np.int64(runs[k, 0]), np.int64(runs[k, 1])
        n = np.int64(runs[k, 2]) - low
        at = (row + 1) * stride + low
        # 1 where unknown: the block's cells nw ne sw se, and around them n_w n_e (above), s_w s_e, w_n w_s, e_n e_s.
        nw, ne, sw, se = (
            scratch[:n],
            scratch[stride:][:n],
            scratch[2 * stride :][:n],
            scratch[3 * stride :][:n],
        )
        n_w, n_e = scratch[4 * stride :][:n], scratch[5 * stride :][:n]
        s_w, s_e = scratch[6 * stride :][:n], scratch[7 * stride :][:n]
        w_n, w_s = scratch[8 * stride :][:n], scratch[9 * stride :][:n]
        e_n, e_s = scratch[10 * stride :][:n], scratch[11 * stride :][:n]
        line = scratch[12 * stride :][:n]
        mark_unknown(nw, weight, at)
        mark_unknown(ne, weight, at + size)
        mark_unknown(sw, weight, at + 2 * size)
        mark_unknown(se, weight, at + 3 * size)
        mark_unknown(n_w, weight, at + 2 * size - stride)
        mark_unknown(n_e, weight, at + 3 * size - stride)
        mark_unknown(s_w, weight, at + stride)
        mark_unknown(s_e, weight, at + size + stride)
        mark_unknown(w_n, weight, at + size - 1)
        mark_unknown(w_s, weight, at + 3 * size - 1)
        mark_unknown(e_n, weight, at + 1)
        mark_unknown(e_s, weight, at + 2 * size + 1)
        to = 2 * (row & 1) * coarse_size + (row // 2 + 1) * coarse_stride + low // 2

        for i in range(n):
            line[i] = half * (ne[i] * e_n[i] + se[i] * e_s[i])
        scatter_row(edge_e, line, to, coarse_size, n)
        for i in range(n):
            line[i] = half * (sw[i] * s_w[i] + se[i] * s_e[i])
        scatter_row(edge_s, line, to, coarse_size, n)

        # A known value beside the block moves away from its centre, one inside the block comes nearer.  Beyond the
        # edge of the image there is no value: nothing counts that would lie there.
        beside = away if row > 0 else zero
        for i in range(n):
            line[i] = beside * (nw[i] * (one - n_w[i]) + ne[i] * (one - n_e[i]))
        for i in range(n):
            line[i] += near * (sw[i] * (one - nw[i]) + se[i] * (one - ne[i]))
        scatter_row(leak_n, line, to, coarse_size, n)
        beside = away if 2 * row + 2 < height else zero
        within = near if 2 * row + 1 < height else zero
        for i in range(n):
            line[i] = beside * (sw[i] * (one - s_w[i]) + se[i] * (one - s_e[i]))
        for i in range(n):
            line[i] += within * (nw[i] * (one - sw[i]) + ne[i] * (one - se[i]))
        scatter_row(leak_s, line, to, coarse_size, n)
        for i in range(n):
            line[i] = away * (nw[i] * (one - w_n[i]) + sw[i] * (one - w_s[i]))
        for i in range(n):
            line[i] += near * (ne[i] * (one - nw[i]) + se[i] * (one - sw[i]))
        if low == 0:
            line[0] -= away * (nw[0] + sw[0])
        scatter_row(leak_w, line, to, coarse_size, n)
        for i in range(n):
            line[i] = away * (ne[i] * (one - e_n[i]) + se[i] * (one - e_s[i]))
        for i in range(n):
            line[i] += near * (nw[i] * (one - ne[i]) + sw[i] * (one - se[i]))
        i = cols - 1 - low
        if i < n:
            line[i] -= near * (nw[i] + sw[i]) if width & 1 else away * (ne[i] + se[i])
        scatter_row(leak_e, line, to, coarse_size, n)


@jit
def add_moved(total, beside, within):
    """total = leaks of two children beside the known value and of two within, seen from the coarse centre."""
    for i in range(total.shape[0]):
        total[i] += moved_away(beside[i])
    for i in range(total.shape[0]):
        total[i] += moved_near(within[i])


@jit
def coarsen_leak(leak, scratch, at, size, coarse_at, coarse_size, n, beside_1, beside_2, within_1, within_2):
    """One direction's leak of a row of coarse cells, from the quarters beside the known value and within."""
    total = scratch[:n]
    for i in range(n):
        total[i] = 0
    a, b = at + beside_1 * size, at + within_1 * size
    add_moved(total, leak[a : a + n], leak[b : b + n])
    a, b = at + beside_2 * size, at + within_2 * size
    add_moved(total, leak[a : a + n], leak[b : b + n])
    scatter_row(leak, scratch, coarse_at, coarse_size, n)


@jit
def coarsen(edge_e, edge_s, leak_n, leak_s, leak_w, leak_e, scratch, runs, table, level):
    """Conductances of level + 1 from those of `level`, by 2 x 2 aggregation; one leak per direction.

    The six fields begin at level 1.  runs: of `level`.  scratch: a row of the finest level.
    """
    stride, size, offset = (
        table[level, STRIDE],
        table[level, QUARTER],
        table[level, OFFSET] - table[1, OFFSET],
    )
    coarse_stride, coarse_size = table[level + 1, STRIDE], table[level + 1, QUARTER]
    coarse_offset = table[level + 1, OFFSET] - table[1, OFFSET]
    for k in range(runs.shape[0]):
        row, low = np.int64(runs[k, 0]), np.int64(runs[k, 1])
        n = np.int64(runs[k, 2]) - low
        at = offset + (row + 1) * stride + low
        to = coarse_offset + 2 * (row & 1) * coarse_size + (row // 2 + 1) * coarse_stride + low // 2
        line = scratch[:n]
        a, b = edge_e[at + size : at + size + n], edge_e[at + 3 * size : at + 3 * size + n]
        for i in range(n):
            line[i] = half_conductance(a[i]) + half_conductance(b[i])
        scatter_row(edge_e, scratch, to, coarse_size, n)
        a, b = edge_s[at + 2 * size : at + 2 * size + n], edge_s[at + 3 * size : at + 3 * size + n]
        for i in range(n):
            line[i] = half_conductance(a[i]) + half_conductance(b[i])
        scatter_row(edge_s, scratch, to, coarse_size, n)
        coarsen_leak(leak_n, scratch, at, size, to, coarse_size, n, 0, 1, 2, 3)
        coarsen_leak(leak_s, scratch, at, size, to, coarse_size, n, 2, 3, 0, 1)
        coarsen_leak(leak_w, scratch, at, size, to, coarse_size, n, 0, 2, 1, 3)
        coarsen_leak(leak_e, scratch, at, size, to, coarse_size, n, 1, 3, 0, 2)


@jit
def weigh(weight, diagonal, edge_e, edge_s, leak_n, leak_s, leak_w, leak_e, segments, table, level):
    """A coarse level's diagonal, the sum of a cell's conductances, and its inverse; returns the number of cells."""
    stride, size, offset = table[level, STRIDE], table[level, QUARTER], table[level, OFFSET]
    skip = table[1, OFFSET]
    cells = 0
    for quarter in range(4):
        upper, left = quarter ^ 2, quarter ^ 1
        for k in range(segments.shape[0]):
            n = segments[k, 1] - segments[k, 0]
            at = offset + quarter * size + segments[k, 0]
            w, d = weight[at : at + n], diagonal[at : at + n]
            at -= skip
            east, south = edge_e[at : at + n], edge_s[at : at + n]
            for i in range(n):
                d[i] = east[i] + south[i]
            north, south = leak_n[at : at + n], leak_s[at : at + n]
            for i in range(n):
                d[i] += north[i] + south[i]
            west, east = leak_w[at : at + n], leak_e[at : at + n]
            for i in range(n):
                d[i] += west[i] + east[i]
            at = offset - skip + upper * size + segments[k, 0] - (0 if quarter & 2 else stride)
            north = edge_s[at : at + n]
            at = offset - skip + left * size + segments[k, 0] - (0 if quarter & 1 else 1)
            west = edge_e[at : at + n]
            for i in range(n):
                d[i] += north[i] + west[i]
            for i in range(n):
                w[i] = np.float32(1.0) / d[i] if d[i] > 0 else np.float32(0.0)
                cells += d[i] > 0
    return cells


@jit
def screen_region(mass, weight, diagonal, segments, table, screening):
    """Draws every unknown of the finest level to its first guess: mass = screening, and the diagonal grows by it."""
    size = table[0, QUARTER]
    for quarter in range(4):
        for k in range(segments.shape[0]):
            at, n = quarter * size + segments[k, 0], segments[k, 1] - segments[k, 0]
            m, w = mass[at : at + n], weight[at : at + n]
            for i in range(n):
                m[i] = screening if w[i] > 0 else np.float32(0.0)
    add_mass(weight, diagonal, mass, segments, table, 0)


@jit
def add_mass(weight, diagonal, mass, segments, table, level):
    """diagonal += mass on a level, and its inverse follows; cells that are outside the region have neither."""
    size, offset = table[level, QUARTER], table[level, OFFSET]
    for quarter in range(4):
        for k in range(segments.shape[0]):
            at, n = offset + quarter * size + segments[k, 0], segments[k, 1] - segments[k, 0]
            m, w, d = mass[at : at + n], weight[at : at + n], diagonal[at : at + n]
            for i in range(n):
                d[i] += m[i]
                w[i] = np.float32(1.0) / d[i] if d[i] > 0 else np.float32(0.0)


@jit
def coarsen_mass(mass, scratch, runs, table, level):
    """mass of level + 1: that of each cell's four children together.  scratch: a row of the finest level."""
    stride, size, offset = table[level, STRIDE], table[level, QUARTER], table[level, OFFSET]
    coarse_stride, coarse_size = table[level + 1, STRIDE], table[level + 1, QUARTER]
    for k in range(runs.shape[0]):
        row, low = np.int64(runs[k, 0]), np.int64(runs[k, 1])
        n = np.int64(runs[k, 2]) - low
        at = offset + (row + 1) * stride + low
        line = scratch[:n]
        for i in range(n):
            line[i] = np.float32(0.0)
        for quarter in range(4):
            m = mass[at + quarter * size : at + quarter * size + n]
            for i in range(n):
                line[i] += m[i]
        to = 2 * (row & 1) * coarse_size + (row // 2 + 1) * coarse_stride + low // 2
        scatter_row(mass, scratch, table[level + 1, OFFSET] + to, coarse_size, n)


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
