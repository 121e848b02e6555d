"""The solution added to pictures; pictures of integers, as they are stored: differences, and rounding into them."""

import numpy as np

from solvers.kernels.policy import inlined, jit, loops
from solvers.layout import QUARTER, STRIDE
from solvers.native.prefetch import prefetch

u = np.uint64  # what arrays are indexed with, see solvers.kernels

AHEAD = 24  # pixels: how far before its turn one is asked for, where they are scattered


@inlined
def float32_bits(value):
    """The bit pattern of a value that is not negative, as a float32."""
    return np.int32(np.float32(value).view(np.int32))


@inlined
def float32_of(bits):
    """The value with this bit pattern."""
    return np.int32(bits).view(np.float32)


@inlined
def largest_of(a, b):
    """The larger one of two bit patterns."""
    return a if a > b else b


@inlined
def beyond_range(value, largest):
    """How far a value leaves 0 ... largest; 0 if it does not."""
    nothing = largest - largest
    return -value if value < nothing else value - largest if value > largest else nothing


@inlined
def rounded(value, largest):
    """A value rounded half to even and kept within 0 ... largest, as an int32."""
    nothing = largest - largest
    return np.int32(np.rint(nothing if value < nothing else largest if value > largest else value))


# --- in rows -----------------------------------------------------------------------------------------------------


@loops
def interleave(line, total, x, at, places, size, channels):
    """line = total + x in pairs of columns of a row, channels interleaved; the first even one is at `at`."""
    zero = line.dtype.type(0)  # of the type to add in
    if channels == 3:  # written out, so that LLVM puts six vectors together
        a, b, c = u(at), u(at + 4 * size), u(at + 8 * size)
        d, e, f = a + u(size), b + u(size), c + u(size)
        for i in range(u(places)):
            line[u(6) * i] = (total[a + i] + zero) + x[a + i]
            line[u(6) * i + u(1)] = (total[b + i] + zero) + x[b + i]
            line[u(6) * i + u(2)] = (total[c + i] + zero) + x[c + i]
            line[u(6) * i + u(3)] = (total[d + i] + zero) + x[d + i]
            line[u(6) * i + u(4)] = (total[e + i] + zero) + x[e + i]
            line[u(6) * i + u(5)] = (total[f + i] + zero) + x[f + i]
    else:
        for channel in range(channels):
            even, step, first = u(at + 4 * channel * size), u(2 * channels), u(channel)
            odd, second = even + u(size), first + u(channels)
            for i in range(u(places)):
                line[first + step * i] = (total[even + i] + zero) + x[even + i]
                line[second + step * i] = (total[odd + i] + zero) + x[odd + i]


@loops
def add_line(target, line, at, n):
    """target[at : at + n] += line."""
    at = u(at)
    nothing = -np.float32(0.0)  # adding it changes nothing, not even -0.0
    for i in range(u(n)):
        target[at + i] += line[i] if line[i] != 0 else nothing


@jit
def add_solution(solution, line, total, x, top, runs, table):
    """solution += total + x, which are added in the type of `line`, the solution's.

    solution: (n, width, channels), rows top ... top + n of the image (`top` is even).  line: scratch for (width + 1) *
    channels values.  runs: those of the rows.
    """
    rows, width, channels = solution.shape
    stride, size = table[0, STRIDE], table[0, QUARTER]
    target = solution.reshape(-1)
    for k in range(runs.shape[0]):
        begin = np.int64(runs[k, 0]) * 2
        low, high = np.int64(runs[k, 1]) * 2, min(np.int64(runs[k, 2]) * 2, width)
        for row in range(max(begin, top), min(begin + 2, top + rows)):
            at = 2 * (row & 1) * size + (begin // 2 + 1) * stride + low // 2
            interleave(line, total, x, at, (high - low + 1) // 2, size, channels)
            add_line(target, line, ((row - top) * width + low) * channels, (high - low) * channels)


@loops
def mark_values(marks, region, at, n, channels):
    """marks = 1 for each value of an unknown pixel, for n pixels from region[at] on."""
    at = u(at)
    if channels == 3:  # written out, so that LLVM puts three vectors together
        for i in range(u(n)):
            mark = np.uint8(region[at + i])
            marks[u(3) * i] = mark
            marks[u(3) * i + u(1)] = mark
            marks[u(3) * i + u(2)] = mark
    else:
        for channel in range(channels):
            first, step = u(channel), u(channels)
            for i in range(u(n)):
                marks[first + step * i] = np.uint8(region[at + i])


@loops
def round_row(target, values, marks, to, at, n, largest):
    """target[to : to + n] = values from `at` on, rounded, where marked.

    Returns how many are clipped, and the bit pattern of how far the furthest leaves the range, in float32.
    """
    to, at = u(to), u(at)
    clipped, furthest = np.int32(0), np.int32(0)
    for i in range(u(n)):
        value, marked = values[at + i], marks[i] != 0
        beyond = beyond_range(value, largest) if marked else largest - largest
        clipped = np.int32(clipped + np.int32(beyond > 0.5))  # in 32 bits, as the values are
        furthest = largest_of(furthest, float32_bits(beyond))
        target[to + i] = rounded(value, largest) if marked else np.int32(target[to + i])
    return clipped, furthest


@jit
def round_into(picture, marks, values, region, left, largest):
    """Pixels of the region, rounded half to even and clipped to 0 ... largest; the others keep what they hold.

    picture: (n, W, channels) integers.  marks: scratch for w * channels bytes.  values: (n, w, channels), for columns
    left ... left + w.  region: (n, w) bool.  largest: of the values' dtype.  Returns how many values are clipped, and
    how far the furthest leaves the range.
    """
    n, width, channels = values.shape
    target, flat, inside = picture.reshape(-1), values.reshape(-1), region.reshape(-1)
    clipped, furthest = np.int64(0), np.int32(0)
    for row in range(n):
        mark_values(marks, inside, row * width, width, channels)
        to = (row * picture.shape[1] + left) * channels
        more, bits = round_row(target, flat, marks, to, row * width * channels, width * channels, largest)
        clipped += more
        furthest = largest_of(furthest, bits)
    return np.float64(clipped), np.float64(float32_of(furthest))


@loops
def round_sum(target, source, line, marks, to, at, n, largest):
    """target[to : to + n] = integers of the source from `at` on + line, rounded, where marked; else as `round_row`."""
    to, at = u(to), u(at)
    clipped, furthest = np.int32(0), np.int32(0)
    for i in range(u(n)):
        value, marked = np.float32(source[at + i]) + line[i], marks[i] != 0
        beyond = beyond_range(value, largest) if marked else largest - largest
        clipped = np.int32(clipped + np.int32(beyond > 0.5))
        furthest = largest_of(furthest, float32_bits(beyond))
        target[to + i] = rounded(value, largest) if marked else np.int32(target[to + i])
    return clipped, furthest


@jit
def round_solution(picture, base, marks, line, total, x, region, corners, largest, first, end, runs, table):
    """`add_solution` and `round_into` in one: picture = base + (total + x) in rows first ... end of the region.

    picture, base: (H, W, channels) integers.  marks, line: scratch for (width + 1) * channels bytes and float32.
    region: (height, width) bool.  corners: where it lies on picture and on base, row and column.  `first` is even.
    runs: those of the rows.  Returns what `round_into` returns.
    """
    channels, width = picture.shape[2], region.shape[1]
    stride, size = table[0, STRIDE], table[0, QUARTER]
    target, source, inside = picture.reshape(-1), base.reshape(-1), region.reshape(-1)
    clipped, furthest = np.int64(0), np.int32(0)
    for k in range(runs.shape[0]):
        begin = np.int64(runs[k, 0]) * 2
        low, high = np.int64(runs[k, 1]) * 2, min(np.int64(runs[k, 2]) * 2, width)
        for row in range(max(begin, first), min(begin + 2, end)):
            at = 2 * (row & 1) * size + (begin // 2 + 1) * stride + low // 2
            interleave(line, total, x, at, (high - low + 1) // 2, size, channels)
            mark_values(marks, inside, row * width + low, high - low, channels)
            to = ((corners[0] + row) * picture.shape[1] + corners[1] + low) * channels
            of = ((corners[2] + row) * base.shape[1] + corners[3] + low) * channels
            more, bits = round_sum(target, source, line, marks, to, of, (high - low) * channels, largest)
            clipped += more
            furthest = largest_of(furthest, bits)
    return np.float64(clipped), np.float64(float32_of(furthest))


# --- pixel by pixel ----------------------------------------------------------------------------------------------


@jit
def subtract_pictures(differences, one, other, rows, cols, corners):
    """differences = one - other at single pixels.

    differences: (n, C) float32.  one, other: (H, W, C) integers, each of its own height and width.  rows, cols: (n,)
    int64.  corners: what to add to them in each picture, row and column.
    """
    channels = differences.shape[1]
    a, b = one.reshape(-1), other.reshape(-1)
    row_a, row_b = one.shape[1] * channels, other.shape[1] * channels
    first_a, first_b = corners[0] * row_a + corners[1] * channels, corners[2] * row_b + corners[3] * channels
    n = rows.shape[0]
    for i in range(n):
        ahead = u(min(i + AHEAD, n - 1))
        prefetch(a, first_a + rows[ahead] * row_a + cols[ahead] * channels)
        prefetch(b, first_b + rows[ahead] * row_b + cols[ahead] * channels)
        row, col = rows[u(i)], cols[u(i)] * channels
        at_a, at_b = first_a + row * row_a + col, first_b + row * row_b + col
        for c in range(channels):
            differences[u(i), u(c)] = np.int32(a[u(at_a + c)]) - np.int32(b[u(at_b + c)])


@inlined
def round_value(target, to, value, largest, clipped, furthest):
    """One value of `round_at`; returns that clipped and furthest of this one and those before."""
    beyond = beyond_range(value, largest)
    target[to] = rounded(value, largest)
    return clipped + np.int64(beyond > 0.5), largest_of(furthest, float32_bits(beyond))


@jit
def round_at(picture, base, correction, place, width, corners, largest):
    """picture = base + correction at single pixels, rounded half to even and clipped to 0 ... largest, a float32.

    picture, base: (H, W, C) integers.  correction: (n, C or more) float64.  place: (n,) int64, row * width + column,
    ascending.  corners: what to add to these in picture and in base, row and column.  Returns what `round_into` does.
    """
    channels, lanes = picture.shape[2], correction.shape[1]
    target, source, values = picture.reshape(-1), base.reshape(-1), correction.reshape(-1)
    line_t, line_s = picture.shape[1] * channels, base.shape[1] * channels
    first_t, first_s = (
        corners[0] * line_t + corners[1] * channels,
        corners[2] * line_s + corners[3] * channels,
    )
    # From a place to where its pixel lies: the rows of the pictures may be longer.
    longer_t, longer_s = line_t - width * channels, line_s - width * channels
    n = place.shape[0]
    row = place[0] // width if n > 0 else np.int64(0)
    next_row = (row + 1) * width
    clipped, furthest = np.int64(0), np.int32(0)
    for i in range(n):
        at = place[u(i)]
        while at >= next_row:
            row += 1
            next_row += width
        ahead = place[u(min(i + AHEAD, n - 1))] * channels  # as if in this row
        prefetch(target, first_t + ahead + row * longer_t)
        prefetch(source, first_s + ahead + row * longer_s)
        to, of = first_t + at * channels + row * longer_t, first_s + at * channels + row * longer_s
        t, s, k = u(to), u(of), u(i * lanes)
        if channels == 3:  # written out: LLVM does not unroll the loop
            one = np.float32(np.float64(source[s]) + values[k])
            two = np.float32(np.float64(source[s + u(1)]) + values[k + u(1)])
            three = np.float32(np.float64(source[s + u(2)]) + values[k + u(2)])
            clipped, furthest = round_value(target, t, one, largest, clipped, furthest)
            clipped, furthest = round_value(target, t + u(1), two, largest, clipped, furthest)
            clipped, furthest = round_value(target, t + u(2), three, largest, clipped, furthest)
        else:
            for c in range(u(channels)):
                value = np.float32(np.float64(source[s + c]) + values[k + c])
                clipped, furthest = round_value(target, t + c, value, largest, clipped, furthest)
    return np.float64(clipped), np.float64(float32_of(furthest))
