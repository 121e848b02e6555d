"""From a region to the runs and coefficients of all levels; see `solvers.hierarchy` for what they mean."""

import numpy as np

from solvers.kernels.policy import inlined, jit, loops
from solvers.layout import (
    ALL,
    BESIDE_KNOWN,
    COLS,
    FIRST_RUN,
    FIRST_SEGMENT,
    HEIGHT,
    LANES,
    NOTHING,
    OFFSET,
    QUARTER,
    STRIDE,
    WIDTH,
)

LEAK_CAP = np.float32(4.0)  # conductance of a known value a quarter of a cell away

u = np.uint64  # what arrays are indexed with, see solvers.kernels


# --- a first look ------------------------------------------------------------------------------------------------


@loops
def mark_columns(columns, region, at, n):
    """columns |= n pixels from region[at] on; returns how many of these are unknown."""
    at = u(at)
    count = np.int32(0)
    for i in range(u(n)):
        pixel = np.uint8(region[at + i])
        columns[i] |= pixel
        count = np.int32(count + np.int32(pixel))  # in 32 bits, of which a vector holds more
    return count


@jit
def find_extent(columns, region):
    """First row with an unknown pixel, the one behind the last, and how many unknown pixels there are.

    columns: (width,) uint8, zeros; those with an unknown pixel become 1.  region: (height, width) bool.
    """
    height, width = region.shape
    flat = region.reshape(-1)
    first, end, unknowns = np.int64(height), np.int64(0), np.int64(0)
    for row in range(height):
        count = np.int64(mark_columns(columns, flat, row * width, width))
        if count > 0:
            first, end = first if unknowns > 0 else np.int64(row), np.int64(row + 1)
            unknowns += count
    return first, end, unknowns


# --- runs --------------------------------------------------------------------------------------------------------


@loops
def mark_pairs(marks, region, upper, lower, n):
    """marks = 1 for each of n blocks of 2 x 2 pixels that holds an unknown one, else 0."""
    upper, lower = u(upper), u(lower)
    for i in range(u(n)):
        above = region[upper + i + i] | region[upper + i + i + u(1)]
        marks[i] = np.uint8(above | region[lower + i + i] | region[lower + i + i + u(1)])


@jit
def find_runs(runs, words, marks, region, gap):
    """Runs of the finest level; returns their number.

    runs: (n, 3) int32, written as far as it goes: pass one without rows to count only.  words: int64 zeros, room for a
    row of places in bytes.  marks: the same memory as bytes.  region: (height, width) bool.  gap: stretches with fewer
    empty places between them become one run.
    """
    height, width = region.shape
    cols, full = (width + 1) // 2, np.int64(0x0101010101010101)
    flat = region.reshape(-1)
    room, count = runs.shape[0], 0
    for row in range((height + 1) // 2):
        upper, lower = 2 * row * width, min(2 * row + 1, height - 1) * width
        mark_pairs(marks, flat, upper, lower, width // 2)
        if width & 1:
            marks[cols - 1] = np.uint8(flat[upper + width - 1] | flat[lower + width - 1])
        low = high = -1  # the open run
        for word in range((cols + 7) // 8):
            if words[word] == 0:
                continue
            if words[word] == full and high == 8 * word:
                high += 8
                continue
            for col in range(8 * word, min(8 * word + 8, cols)):
                if marks[col] == 0:
                    continue
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


@jit
def lay_out(runs, segments, table, scratch, finest, gap, segment_gap, longest):
    """Runs and segments of all levels, and where they begin; returns how many runs there are.

    runs: (n, 3) int32, segments: (n, 4) int64, written if there is room for all.  table: `layout_table`'s, of which
    FIRST_RUN and FIRST_SEGMENT are filled in.  scratch: (2, n_finest, 3) int32.  finest: (n_finest, 3) int32, from
    `find_runs`.  The rest are distances, see `find_runs` and `join_runs`.
    """
    exact, n = finest, finest.shape[0]
    first = first_segment = 0
    for level in range(table.shape[0] - 1):
        if level > 0:
            coarse = scratch[level & 1]
            n = coarsen_runs(coarse, exact[:n], gap)
            exact = coarse
        end = first + n
        table[level + 1, FIRST_RUN] = end
        if end <= runs.shape[0]:
            for k in range(
                n
            ):  # both ends moved outwards to whole vectors, the first one to those of the next level
                runs[first + k, 0] = exact[k, 0]
                runs[first + k, 1] = exact[k, 1] & (-2 * LANES)
                runs[first + k, 2] = (exact[k, 2] + LANES - 1) & -LANES
            stride = table[level, STRIDE]
            first_segment += join_runs(
                segments[first_segment:], runs[first:end], stride, first, segment_gap, longest
            )
            table[level + 1, FIRST_SEGMENT] = first_segment
        first = end
    return first


# --- coefficients ------------------------------------------------------------------------------------------------


@loops
def spread(weight, diagonal, region, even, odd, at, n):
    """n pairs of pixels from region[at] on: a quarter and four where unknown, else zeros."""
    even, odd, at = u(even), u(odd), u(at)
    nothing, four, quarter_of_one = np.float32(0.0), np.float32(4.0), np.float32(0.25)
    for i in range(u(n)):
        a, b = region[at + i + i], region[at + i + i + u(1)]
        weight[even + i] = quarter_of_one if a else nothing
        diagonal[even + i] = four if a else nothing
        weight[odd + i] = quarter_of_one if b else nothing
        diagonal[odd + i] = four if b else nothing


@loops
def share_out(share, region, to, at, width, above, below, n):
    """The share of every second pixel from region[at] on, n of them; above, below: 0 where the image ends there."""
    to, at, north, south = u(to), u(at), u(at - above * width), u(at + below * width)
    for i in range(u(n)):
        inside = region[at + i + i] & region[at + i + i - u(1)] & region[at + i + i + u(1)]
        inside &= region[north + i + i] & region[south + i + i]
        share[to + i] = ALL if inside else (BESIDE_KNOWN if region[at + i + i] else NOTHING)


@jit
def weigh_pixel(weight, diagonal, share, region, row, col, table):
    """The same for one pixel, which may lie at the edge of the image and have fewer neighbours."""
    height, width = region.shape
    at = (2 * (row & 1) + (col & 1)) * table[0, QUARTER] + (row // 2 + 1) * table[0, STRIDE] + col // 2
    neighbours = unknowns = np.int64(0)
    for side in range(4):
        r, c = row + (side - 1 if side & 1 == 0 else 0), col + (side - 2 if side & 1 else 0)
        if r >= 0 and r < height and c >= 0 and c < width:
            neighbours += 1
            unknowns += np.int64(region[r, c])
    if region[row, col]:
        diagonal[at] = neighbours
        weight[at] = np.float32(1.0) / np.float32(neighbours)
        share[at] = ALL if unknowns == neighbours else BESIDE_KNOWN
    else:
        share[at] = NOTHING


@jit
def weigh_region(weight, diagonal, share, region, runs, table):
    """The finest level's coefficients: diagonal = |N_p|, weight = 1 / |N_p| in the region, both 0 outside it; and the
    share of black pixels.
    """
    height, width = region.shape
    stride, size = table[0, STRIDE], table[0, QUARTER]
    flat = region.reshape(-1)
    for k in range(runs.shape[0]):
        row, low = np.int64(runs[k, 0]), np.int64(runs[k, 1])
        high = min(np.int64(runs[k, 2]), width // 2)
        for pixel_row in range(2 * row, min(2 * row + 2, height)):
            at = 2 * (pixel_row & 1) * size + (row + 1) * stride + low
            pixel = pixel_row * width + 2 * low
            spread(weight, diagonal, flat, at, at + size, pixel, high - low)
            # Of the row's black pixels, all but those at the ends of the image's row, which come below.
            odd = (pixel_row & 1) ^ 1
            begin = 1 if low == 0 and not odd else 0
            end = high - low if 2 * (high - 1) + odd < width - 1 else high - low - 1
            above, below = np.int64(pixel_row > 0), np.int64(pixel_row < height - 1)
            share_out(
                share,
                flat,
                at + odd * size + begin,
                pixel + odd + 2 * begin,
                width,
                above,
                below,
                end - begin,
            )
            if pixel_row == 0 or pixel_row == height - 1:
                for col in range(2 * low, min(2 * np.int64(runs[k, 2]), width)):
                    weigh_pixel(weight, diagonal, share, region, pixel_row, col, table)
            elif low == 0:
                weigh_pixel(weight, diagonal, share, region, pixel_row, 0, table)
            if 2 * np.int64(runs[k, 2]) >= width:
                weigh_pixel(weight, diagonal, share, region, pixel_row, width - 1, table)


@inlined
def half_conductance(w):
    """A fine edge that crosses between two coarse cells, whose centres lie twice as far apart: w in series with 1."""
    return w / (np.float32(1.0) + w)


@inlined
def moved_away(g):
    """The conductance to the same known value from a centre that lies a quarter of a coarse cell further away."""
    return g / max(np.float32(1.0) + np.float32(0.25) * g, g / LEAK_CAP)


@inlined
def moved_near(g):
    """The same from a quarter of a coarse cell nearer."""
    return g / max(np.float32(1.0) - np.float32(0.25) * g, g / LEAK_CAP)


@inlined
def is_unknown(weight, at):
    """1 where the weight is positive, else 0."""
    return np.float32(1.0) if weight[at] > 0 else np.float32(0.0)


@loops
def scatter_row(coarse, scratch, first, at, size, n):
    """A row of n coarse cells into quarters: even columns into the one that holds `at`, odd ones into the next."""
    even, odd, first = u(at), u(at + size), u(first)
    for i in range(u((n + 1) // 2)):
        coarse[even + i] = scratch[first + i + i]
        coarse[odd + i] = scratch[first + i + i + u(1)]


@loops
def coarse_conductances(lines, weight, at, size, stride, n, north, south, within_s):
    """East and south edge, and leaks to the north, south, west and east, of n blocks from place `at` on.

    A known value beside the block moves away from its centre, one inside the block comes nearer.  north, south,
    within_s: 0 where the image ends above, below or within the block, else 1: there is no value to leak to.
    """
    one = np.float32(1.0)
    half, away, near = half_conductance(one), moved_away(one), moved_near(one)
    step = u(stride)
    # The block's cells, and around them those above, below, west and east.
    i_nw, i_ne, i_sw, i_se = u(at), u(at + size), u(at + 2 * size), u(at + 3 * size)
    i_n_w, i_n_e, i_s_w, i_s_e = i_sw - step, i_se - step, i_nw + step, i_ne + step
    i_w_n, i_w_s, i_e_n, i_e_s = i_ne - u(1), i_se - u(1), i_nw + u(1), i_sw + u(1)
    for i in range(u(n)):
        nw, ne = is_unknown(weight, i_nw + i), is_unknown(weight, i_ne + i)
        sw, se = is_unknown(weight, i_sw + i), is_unknown(weight, i_se + i)
        n_w, n_e = is_unknown(weight, i_n_w + i), is_unknown(weight, i_n_e + i)
        s_w, s_e = is_unknown(weight, i_s_w + i), is_unknown(weight, i_s_e + i)
        w_n, w_s = is_unknown(weight, i_w_n + i), is_unknown(weight, i_w_s + i)
        e_n, e_s = is_unknown(weight, i_e_n + i), is_unknown(weight, i_e_s + i)
        lines[i] = half * (ne * e_n + se * e_s)
        lines[step + i] = half * (sw * s_w + se * s_e)
        lines[u(2) * step + i] = north * away * (nw * (one - n_w) + ne * (one - n_e)) + near * (
            sw * (one - nw) + se * (one - ne)
        )
        lines[u(3) * step + i] = south * away * (sw * (one - s_w) + se * (one - s_e)) + within_s * near * (
            nw * (one - sw) + ne * (one - se)
        )
        lines[u(4) * step + i] = away * (nw * (one - w_n) + sw * (one - w_s)) + near * (
            ne * (one - nw) + se * (one - sw)
        )
        lines[u(5) * step + i] = away * (ne * (one - e_n) + se * (one - e_s)) + near * (
            nw * (one - ne) + sw * (one - se)
        )


@jit
def coarsen_region(edge_e, edge_s, leak_n, leak_s, leak_w, leak_e, lines, weight, runs, table):
    """Conductances of level 1 from the region: `coarsen` with all fine conductances 0 or 1.

    The six fields begin at level 1 and hold zeros; they are written at the places of the finest level's `runs`, which
    are the cells of level 1.  weight: the finest level's, positive where unknown.  lines: six of its rows, scratch.
    """
    height, width, cols = table[0, HEIGHT], table[0, WIDTH], table[0, COLS]
    stride, size = table[0, STRIDE], table[0, QUARTER]
    coarse_stride, coarse_size = table[1, STRIDE], table[1, QUARTER]
    one, zero = np.float32(1.0), np.float32(0.0)
    away, near = moved_away(one), moved_near(one)
    for k in range(runs.shape[0]):
        row, low = np.int64(runs[k, 0]), np.int64(runs[k, 1])
        n = np.int64(runs[k, 2]) - low
        at = (row + 1) * stride + low
        coarse_conductances(
            lines, weight, at, size, stride, n,
            one if row > 0 else zero,
            one if 2 * row + 2 < height else zero,
            one if 2 * row + 1 < height else zero,
        )  # fmt: skip
        # Beyond the edge of the image there is no value: nothing counts that would lie there.
        if low == 0:
            lines[4 * stride] -= away * (is_unknown(weight, at) + is_unknown(weight, at + 2 * size))
        last = cols - 1 - low
        if last < n and width & 1:
            beside = is_unknown(weight, at + last) + is_unknown(weight, at + 2 * size + last)
            lines[5 * stride + last] -= near * beside
        elif last < n:
            beside = is_unknown(weight, at + size + last) + is_unknown(weight, at + 3 * size + last)
            lines[5 * stride + last] -= away * beside
        to = 2 * (row & 1) * coarse_size + (row // 2 + 1) * coarse_stride + low // 2
        scatter_row(edge_e, lines, 0, to, coarse_size, n)
        scatter_row(edge_s, lines, stride, to, coarse_size, n)
        scatter_row(leak_n, lines, 2 * stride, to, coarse_size, n)
        scatter_row(leak_s, lines, 3 * stride, to, coarse_size, n)
        scatter_row(leak_w, lines, 4 * stride, to, coarse_size, n)
        scatter_row(leak_e, lines, 5 * stride, to, coarse_size, n)


@loops
def coarse_edge(line, edge, first, second, n):
    """The edge between two coarse cells, made of two fine ones."""
    first, second = u(first), u(second)
    for i in range(u(n)):
        line[i] = half_conductance(edge[first + i]) + half_conductance(edge[second + i])


@loops
def coarse_leak(line, leak, at, size, n, beside_1, beside_2, within_1, within_2):
    """One direction's leak of a row of coarse cells, from the quarters beside the known value and within."""
    a, b, c, d = (
        u(at + beside_1 * size),
        u(at + beside_2 * size),
        u(at + within_1 * size),
        u(at + within_2 * size),
    )
    for i in range(u(n)):
        beside = moved_away(leak[a + i]) + moved_away(leak[b + i])
        line[i] = beside + (moved_near(leak[c + i]) + moved_near(leak[d + i]))


@jit
def coarsen(edge_e, edge_s, leak_n, leak_s, leak_w, leak_e, scratch, runs, table, level):
    """Conductances of level + 1 from those of `level`, by 2 x 2 aggregation; one leak per direction.

    The six fields begin at level 1.  runs: of `level`.  scratch: a row of the finest level.
    """
    stride, size = table[level, STRIDE], table[level, QUARTER]
    coarse_stride, coarse_size = table[level + 1, STRIDE], table[level + 1, QUARTER]
    for k in range(runs.shape[0]):
        row, low = np.int64(runs[k, 0]), np.int64(runs[k, 1])
        n = np.int64(runs[k, 2]) - low
        at = table[level, OFFSET] - table[1, OFFSET] + (row + 1) * stride + low
        to = table[level + 1, OFFSET] - table[1, OFFSET]
        to += 2 * (row & 1) * coarse_size + (row // 2 + 1) * coarse_stride + low // 2
        coarse_edge(scratch, edge_e, at + size, at + 3 * size, n)
        scatter_row(edge_e, scratch, 0, to, coarse_size, n)
        coarse_edge(scratch, edge_s, at + 2 * size, at + 3 * size, n)
        scatter_row(edge_s, scratch, 0, to, coarse_size, n)
        coarse_leak(scratch, leak_n, at, size, n, 0, 1, 2, 3)
        scatter_row(leak_n, scratch, 0, to, coarse_size, n)
        coarse_leak(scratch, leak_s, at, size, n, 2, 3, 0, 1)
        scatter_row(leak_s, scratch, 0, to, coarse_size, n)
        coarse_leak(scratch, leak_w, at, size, n, 0, 2, 1, 3)
        scatter_row(leak_w, scratch, 0, to, coarse_size, n)
        coarse_leak(scratch, leak_e, at, size, n, 1, 3, 0, 2)
        scatter_row(leak_e, scratch, 0, to, coarse_size, n)


@loops
def weigh_places(
    weight, diagonal, share, edge_e, edge_s, leak_n, leak_s, leak_w, leak_e, own, c_own, c_north, c_west, n
):
    """The diagonal of n cells and its inverse; returns how many there are."""
    own, c_own, c_north, c_west = u(own), u(c_own), u(c_north), u(c_west)
    cells = np.int64(0)
    for i in range(u(n)):
        edges = (edge_e[c_own + i] + edge_s[c_own + i]) + (edge_s[c_north + i] + edge_e[c_west + i])
        leaks = (leak_n[c_own + i] + leak_s[c_own + i]) + (leak_w[c_own + i] + leak_e[c_own + i])
        total = edges + leaks
        diagonal[own + i] = total
        weight[own + i] = np.float32(1.0) / total if total > 0 else np.float32(0.0)
        share[own + i] = (ALL if leaks == 0 else BESIDE_KNOWN) if total > 0 else NOTHING
        cells += total > 0
    return cells


@jit
def weigh(weight, diagonal, share, edge_e, edge_s, leak_n, leak_s, leak_w, leak_e, segments, table, level):
    """A coarse level's diagonal, the sum of a cell's conductances, and its inverse; returns the number of cells."""
    stride, size, offset = table[level, STRIDE], table[level, QUARTER], table[level, OFFSET]
    skip = table[1, OFFSET]
    cells = np.int64(0)
    for quarter in range(4):
        for k in range(segments.shape[0]):
            at, n = segments[k, 0], segments[k, 1] - segments[k, 0]
            own = offset + quarter * size + at
            north = offset - skip + (quarter ^ 2) * size + at - (0 if quarter & 2 else stride)
            west = offset - skip + (quarter ^ 1) * size + at - (0 if quarter & 1 else 1)
            cells += weigh_places(
                weight, diagonal, share, edge_e, edge_s, leak_n, leak_s, leak_w, leak_e, own, own - skip, north, west,
                n,
            )  # fmt: skip
    return cells


@jit
def build_levels(
    unknowns, weight, diagonal, share, edge_e, edge_s, leak_n, leak_s, leak_w, leak_e, scratch, runs, segments, table,
    first, few,
):  # fmt: skip
    """The coefficients of levels from `first` on, up to the first one of at most `few` unknowns; returns its end.

    unknowns: (n_levels,) int64, their number per level, of which those before `first` are given.  scratch: six rows of
    the finest level.
    """
    for level in range(first, table.shape[0] - 1):
        if unknowns[level - 1] <= few:
            return level
        fine = runs[table[level - 1, FIRST_RUN] : table[level, FIRST_RUN]]
        own = segments[table[level, FIRST_SEGMENT] : table[level + 1, FIRST_SEGMENT]]
        if level == 1:
            coarsen_region(edge_e, edge_s, leak_n, leak_s, leak_w, leak_e, scratch, weight, fine, table)
        else:
            coarsen(edge_e, edge_s, leak_n, leak_s, leak_w, leak_e, scratch, fine, table, level - 1)
        unknowns[level] = weigh(
            weight, diagonal, share, edge_e, edge_s, leak_n, leak_s, leak_w, leak_e, own, table, level
        )
    return table.shape[0] - 1


@jit
def screen(mass, weight, diagonal, scratch, runs, segments, table, screening):
    """Draws every unknown to its first guess: mass = screening on the finest level, and what that makes on all others.

    mass: as `diagonal`, zeros.  scratch: a row of the finest level.  The diagonals of all levels grow by their mass.
    """
    size = table[0, QUARTER]
    for quarter in range(4):
        for k in range(table[1, FIRST_SEGMENT]):
            at, n = quarter * size + segments[k, 0], segments[k, 1] - segments[k, 0]
            m, w = mass[at : at + n], weight[at : at + n]
            for i in range(n):
                m[i] = screening if w[i] > 0 else np.float32(0.0)
    for level in range(table.shape[0] - 1):
        own = segments[table[level, FIRST_SEGMENT] : table[level + 1, FIRST_SEGMENT]]
        if level > 0:
            fine = runs[table[level - 1, FIRST_RUN] : table[level, FIRST_RUN]]
            coarsen_mass(mass, scratch, fine, table, level - 1)
        add_mass(weight, diagonal, mass, own, table, level)


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
        scatter_row(mass, scratch, 0, table[level + 1, OFFSET] + to, coarse_size, n)


@jit
def factor_band(band):
    """Cholesky factor of a symmetric positive definite band matrix, in place.

    band: (n, bandwidth + 1) float64, band[i, k] = A[i, i - k]; on return the same of L with A = L L^T, but
    1 / L[i, i] in place of L[i, i].
    """
    n, bandwidth = band.shape[0], band.shape[1] - 1
    for i in range(n):
        for k in range(min(i, bandwidth), 0, -1):
            j = i - k
            total = band[i, k]
            for m in range(1, min(bandwidth - k, j) + 1):
                total -= band[i, k + m] * band[j, m]
            band[i, k] = total * band[j, 0]
        total = band[i, 0]
        for m in range(1, min(bandwidth, i) + 1):
            total -= band[i, m] * band[i, m]
        band[i, 0] = 1.0 / np.sqrt(total)


@inlined
def place_of(row, col, stride, size):
    """Where a cell lies in a channel of its level."""
    return (2 * (row & 1) + (col & 1)) * size + (row // 2 + 1) * stride + col // 2


@jit
def solve_band(values, band):
    """values = A^-1 values, by A's factor from `factor_band`.  values: (n,) float64."""
    n, bandwidth = band.shape[0], band.shape[1] - 1
    for i in range(n):
        for k in range(1, min(bandwidth, i) + 1):
            values[i] -= band[i, k] * values[i - k]
        values[i] *= band[i, 0]
    for i in range(n - 1, -1, -1):
        for k in range(1, min(bandwidth, n - 1 - i) + 1):
            values[i] -= band[i + k, k] * values[i + k]
        values[i] *= band[i, 0]


@jit
def factor_coarsest(band, cells, ones, number, diagonal, edge_e, edge_s, table, level):
    """Cholesky factor of the coarsest level's matrix, its cells numbered along the longer side to keep the band narrow.

    band: (n, bandwidth + 1) float64 zeros, see `factor_band`.  cells: (n,) int64, where each cell lies in a channel.
    ones: (n,) float64, all 1; becomes A^-1 1, the largest value of which is returned.  number: as many int64 as the
    grid has cells, scratch.
    """
    height, width = table[level, HEIGHT], table[level, WIDTH]
    stride, size, offset = table[level, STRIDE], table[level, QUARTER], table[level, OFFSET]
    skip = table[1, OFFSET]
    short, long_ = min(height, width), max(height, width)
    count = np.int64(0)
    for a in range(long_):
        for b in range(short):
            row, col = (a, b) if height >= width else (b, a)
            at = place_of(row, col, stride, size)
            number[a * short + b] = -1
            if not diagonal[offset + at] > 0:
                continue
            number[a * short + b] = count
            cells[count] = at
            band[count, 0] = diagonal[offset + at]
            for across in range(2):  # the neighbour before this one across the grid, and along it
                if (b if across else a) == 0:
                    continue
                before = number[a * short + b - (1 if across else short)]
                if before < 0:
                    continue
                edge = np.float64(1.0)  # as all are on the finest level
                if level > 0:
                    fine = offset - skip + cells[before]
                    is_west = (across == 1) == (height >= width)
                    edge = np.float64(edge_e[fine] if is_west else edge_s[fine])
                band[count, count - before] = -edge
            count += 1
    factor_band(band)
    solve_band(ones, band)
    largest = 0.0
    for i in range(count):
        largest = max(largest, ones[i])
    return largest


# --- the boundary ------------------------------------------------------------------------------------------------


@loops
def mark_rim(marks, region, at, above, below, width):
    """marks = 1 where a pixel of a row is known and one above, below, left or right is not; all but both ends."""
    at, above, below = u(at), u(above), u(below)
    for i in range(u(1), u(width - 1)):
        beside = region[at + i - u(1)] | region[at + i + u(1)]
        near = region[above + i] | region[below + i] | beside
        marks[i] = np.uint8(1) if near and not region[at + i] else np.uint8(0)


@inlined
def list_marked(marked, words, n):
    """Which of n words are not zero; returns how many.  No branch: it could not be foreseen."""
    count = np.int64(0)
    for word in range(n):
        marked[u(count)] = word  # if it is none, the next one comes here
        count += words[u(word)] != 0
    return count


@jit
def find_rim(rows, cols, region, words, marks, marked):
    """Rows and columns of the known pixels with an unknown neighbour, row by row; returns how many there are.

    rows, cols: (n + 1,) int64, room for n and for what is tried in between.  words: int64 zeros, enough for a row of
    bytes and one more.  marks: the same memory as bytes.  marked: as many int64, scratch.
    """
    height, width = region.shape
    flat = region.reshape(-1)
    room, count = np.int64(rows.shape[0] - 1), np.int64(0)
    for row in range(height):
        at = row * width
        # Where the image ends the pixel itself stands for the one beyond: it is not both known and unknown.
        above, below = (at if row == 0 else at - width), (at if row == height - 1 else at + width)
        mark_rim(marks, flat, at, above, below, width)
        for col in (0, width - 1):
            near = flat[above + col] | flat[below + col]
            near |= (col > 0 and flat[at + col - 1]) | (col < width - 1 and flat[at + col + 1])
            marks[col] = np.uint8(1) if near and not flat[at + col] else np.uint8(0)
        for k in range(list_marked(marked, words, (width + 7) // 8)):
            first = 8 * marked[u(k)]
            for col in range(first, first + 8):  # none is marked beyond the row
                here = u(min(count, room))
                rows[here], cols[here] = row, col
                count += np.int64(marks[u(col)])
    return count
