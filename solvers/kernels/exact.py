"""Between pictures and the layout, and between float32 and float64."""

import numpy as np

from solvers.kernels.policy import inlined, jit, loops
from solvers.layout import HEIGHT, QUARTER, STRIDE, WIDTH

ABS_BITS = np.int64(0x7FFFFFFFFFFFFFFF)  # all but the sign of a float64

u = np.uint64  # what arrays are indexed with, see solvers.kernels


@inlined
def bits_of(value):
    """The bit pattern of |value|, a float64: as integers these order like the values, with NaN on top."""
    return np.float64(value).view(np.int64) & ABS_BITS


@inlined
def largest_of(a, b):
    """The larger one of two bit patterns."""
    return a if a > b else b


# --- the right-hand side -----------------------------------------------------------------------------------------


@loops
def sum_up(line, to, f, own, row, channels, across, pair, down, n):
    """line = the sum of v_pq - (f_p - f_q) over all four neighbours, n values from line[to] on.

    own: where they begin in f, and in `down`; pair: in `across`.  row: values in a row of f.
    """
    to, own, pair, channels = u(to), u(own), u(pair), u(channels)
    north, south, west, east = own - u(row), own + u(row), own - channels, own + channels
    for i in range(u(n)):
        middle = np.float64(f[own + i])
        vertical = (np.float64(f[north + i]) - middle) + (np.float64(f[south + i]) - middle)
        horizontal = (np.float64(f[west + i]) - middle) + (np.float64(f[east + i]) - middle)
        along = np.float64(across[pair + i]) - np.float64(across[pair - channels + i])
        line[to + i] = ((vertical + horizontal) + along - np.float64(down[north + i])) + np.float64(
            down[own + i]
        )


@loops
def set_differences(line, to, f, north, south, own, n):
    """line = (f at north - f) + (f at south - f), n values from line[to] on; the others say where they begin in f."""
    to, north, south, own = u(to), u(north), u(south), u(own)
    for i in range(u(n)):
        middle = np.float64(f[own + i])
        line[to + i] = (np.float64(f[north + i]) - middle) + (np.float64(f[south + i]) - middle)


@loops
def add_differences(line, to, f, west, east, own, n):
    """line += (f at west - f) + (f at east - f), n values from line[to] on."""
    to, west, east, own = u(to), u(west), u(east), u(own)
    for i in range(u(n)):
        middle = np.float64(f[own + i])
        line[to + i] += (np.float64(f[west + i]) - middle) + (np.float64(f[east + i]) - middle)


@loops
def add_difference(line, to, f, plus, minus, n):
    """line += f at plus - f at minus, n values from line[to] on."""
    to, plus, minus = u(to), u(plus), u(minus)
    for i in range(u(n)):
        line[to + i] += np.float64(f[plus + i]) - np.float64(f[minus + i])


@loops
def add_values(line, to, f, at, n, sign):
    """line += f, or -f, n values from line[to] on."""
    to, at = u(to), u(at)
    for i in range(u(n)):
        line[to + i] += sign * np.float64(f[at + i])


@jit
def residual_of_pixels(line, at, f, v, w, more, width, channels, y, is_first, is_last, low, high):
    """`residual_of_row` step by step, from line[at] on: for any pixels, and whichever arrays there are.

    f, v, w, more: values, across, down and rhs as vectors.  (What makes one of an array might raise, for all that LLVM
    knows of a function that it does not inline.)
    """
    start, stop, pixels = low * channels, high * channels, width * channels
    n = stop - start
    # Values from `begin` to `end` have a neighbour on both sides.
    begin, end = max(start, channels), max(min(stop, pixels - channels), channels)
    west_edge, east_edge = low == 0 and width > 1, high == width and width > 1
    inner, to, last = max(end - begin, 0), at + begin - start, at + n - channels

    own = y * pixels
    # A pixel beyond the edge, in whose place stands the pixel itself, makes no difference.
    north = own + start - (0 if is_first else pixels)
    south = own + start + (0 if is_last else pixels)
    set_differences(line, at, f, north, south, own + start, n)
    add_differences(line, to, f, own + begin - channels, own + begin + channels, own + begin, inner)
    if west_edge:
        add_difference(line, at, f, own + channels, own, channels)
    if east_edge:
        add_difference(line, last, f, own + stop - 2 * channels, own + stop - channels, channels)
    if v.shape[0] > 0:
        pairs = y * (pixels - channels)
        add_difference(line, to, v, pairs + begin, pairs + begin - channels, inner)
        if west_edge:
            add_values(line, at, v, pairs, channels, 1.0)
        if east_edge:
            add_values(line, last, v, pairs + stop - 2 * channels, channels, -1.0)
    if w.shape[0] > 0:
        if not is_first:
            add_values(line, at, w, own - pixels + start, n, -1.0)
        if not is_last:
            add_values(line, at, w, own + start, n, 1.0)
    if more.shape[0] > 0:
        add_values(line, at, more, own + start, n, 1.0)


@jit
def residual_of_row(line, values, across, down, rhs, y, is_first, is_last, low, high):
    """line = rhs_p + sum over q of v_pq - (f_p - f_q) for columns low ... high of row y of the arrays.

    line: channels interleaved, as in the arrays.  is_first, is_last: whether it is the image's first row, its last.
    """
    width, channels = values.shape[1:]
    f, v, w, more = values.reshape(-1), across.reshape(-1), down.reshape(-1), rhs.reshape(-1)
    if is_first or is_last or v.shape[0] == 0 or w.shape[0] == 0 or more.shape[0] > 0:
        residual_of_pixels(line, 0, f, v, w, more, width, channels, y, is_first, is_last, low, high)
        return
    begin, end = max(low, 1), min(high, width - 1)
    pixels = width * channels
    at, to, pair = begin * channels, (begin - low) * channels, (y * (width - 1) + begin) * channels
    n = max(end - begin, 0) * channels
    sum_up(line, to, f, y * pixels + at, pixels, channels, v, pair, w, n)
    if low < begin:
        residual_of_pixels(line, 0, f, v, w, more, width, channels, y, is_first, is_last, low, begin)
    if begin <= end < high:
        residual_of_pixels(line, to + n, f, v, w, more, width, channels, y, is_first, is_last, end, high)


@loops
def put_three(b, at, size, line, weight, n):
    """Sums of three channels in the line to b, for n pairs of pixels: those of even columns go to one quarter, those
    of odd ones to the next one, and the places of both begin at `at` in theirs; 0 outside the region.

    Returns how many float32 did not hold exactly.  Written out, so that LLVM loads and sorts whole vectors.
    """
    at, size = u(at), u(size)
    odd, green, blue = at + size, u(4) * size, u(8) * size
    inexact = np.int64(0)
    for i in range(u(n)):
        red_0, green_0, blue_0 = line[u(6) * i], line[u(6) * i + u(1)], line[u(6) * i + u(2)]
        red_1, green_1, blue_1 = line[u(6) * i + u(3)], line[u(6) * i + u(4)], line[u(6) * i + u(5)]
        inside_0, inside_1 = weight[at + i] > 0, weight[odd + i] > 0
        red_0, green_0, blue_0 = (
            red_0 if inside_0 else 0.0, green_0 if inside_0 else 0.0, blue_0 if inside_0 else 0.0,
        )  # fmt: skip
        red_1, green_1, blue_1 = (
            red_1 if inside_1 else 0.0, green_1 if inside_1 else 0.0, blue_1 if inside_1 else 0.0,
        )  # fmt: skip
        b[at + i], b[at + green + i], b[at + blue + i] = red_0, green_0, blue_0
        b[odd + i], b[odd + green + i], b[odd + blue + i] = red_1, green_1, blue_1
        inexact += (
            (np.float32(red_0) != red_0) | (np.float32(green_0) != green_0) | (np.float32(blue_0) != blue_0)
        )
        inexact += (
            (np.float32(red_1) != red_1) | (np.float32(green_1) != green_1) | (np.float32(blue_1) != blue_1)
        )
    return inexact


@loops
def put(b, to, line, first, step, weight, at, n):
    """n values of b from the line, 0 outside the region; returns how many float32 did not hold exactly."""
    to, at = u(to), u(at)
    inexact = np.int64(0)
    for i in range(u(n)):
        sum_ = line[u(first) + u(step) * i] if weight[at + i] > 0 else 0.0
        b[to + i] = sum_
        inexact += np.float32(sum_) != sum_
    return inexact


@loops
def put_less(b, to, line, first, step, weight, diagonal, at, total, north, west, stride, n):
    """The same less A total; `north` and `west` are where the neighbours in `total` begin, those behind them follow."""
    to, at, north, west = u(to), u(at), u(north), u(west)
    south, east = north + u(stride), west + u(1)
    for i in range(u(n)):
        image = np.float64(diagonal[at + i]) * total[to + i] - (
            (np.float64(total[north + i]) + total[south + i])
            + (np.float64(total[west + i]) + total[east + i])
        )
        b[to + i] = line[u(first) + u(step) * i] - image if weight[at + i] > 0 else 0.0


@jit
def assemble(b, line, total, values, across, down, rhs, top, first, end, weight, diagonal, runs, table):
    """b = the problem's residual at f + total, for rows first ... end of the image (`first` is even).

    line: scratch for (width + 1) * channels sums, float64.  total: as b, or empty for zeros.  values: (n, width,
    channels) f, known outside the region, first guess inside; row `top` of the image comes first.  across, down: v on
    pixel pairs (`Guidance`); rhs: like values; arrays without rows stand for zeros.  runs: those of the rows.

    Returns whether float32 held every value of b exactly.
    """
    channels = values.shape[2]
    height, width, stride, size = table[0, HEIGHT], table[0, WIDTH], table[0, STRIDE], table[0, QUARTER]
    step = 2 * channels
    inexact = np.int64(0)
    for k in range(runs.shape[0]):
        begin = np.int64(runs[k, 0]) * 2
        low, high = np.int64(runs[k, 1]) * 2, min(np.int64(runs[k, 2]) * 2, width)
        for row in range(max(begin, first), min(begin + 2, end)):
            residual_of_row(
                line, values, across, down, rhs, row - top, row == 0, row == height - 1, low, high
            )
            at = (begin // 2 + 1) * stride + low // 2
            if channels == 3 and total.shape[0] == 0:
                # A column more than there may be: nothing is inside the region there.
                inexact += put_three(b, 2 * (row & 1) * size + at, size, line, weight, (high - low + 1) // 2)
                continue
            for side in range(2):
                quarter, n = 2 * (row & 1) + side, (high - low - side + 1) // 2
                own = quarter * size + at
                for channel in range(channels):
                    plane, first_sum = 4 * channel * size, side * channels + channel
                    if total.shape[0] == 0:
                        inexact += put(b, plane + own, line, first_sum, step, weight, own, n)
                        continue
                    north = plane + (quarter ^ 2) * size + at - (0 if quarter & 2 else stride)
                    west = plane + (quarter ^ 1) * size + at - (0 if quarter & 1 else 1)
                    put_less(
                        b, plane + own, line, first_sum, step, weight, diagonal, own, total, north, west, stride, n
                    )  # fmt: skip
    return inexact == 0


@jit
def assemble_rim(b, values, rows, cols, weight, table):
    """The same where the first guess and v are zero: b += the known values beside each unknown; b holds zeros.

    values: (n, channels) of the known pixels in `rows` and `cols`.  They are integers: the order of a sum is nothing.
    """
    height, width, stride, size = table[0, HEIGHT], table[0, WIDTH], table[0, STRIDE], table[0, QUARTER]
    for k in range(rows.shape[0]):
        for side in range(4):
            row = rows[k] + (side - 1 if side & 1 == 0 else 0)
            col = cols[k] + (side - 2 if side & 1 == 1 else 0)
            if row < 0 or row >= height or col < 0 or col >= width:
                continue
            at = (2 * (row & 1) + (col & 1)) * size + (row // 2 + 1) * stride + col // 2
            if weight[at] > 0:
                for channel in range(values.shape[1]):
                    b[4 * channel * size + at] += values[k, channel]


# --- from stage to stage -----------------------------------------------------------------------------------------


@loops
def fold(total, x, segments, table, channels):
    """total += x, in float32; x becomes what was really added, so that the residual can follow it exactly."""
    size = table[0, QUARTER]
    for line in range(4 * channels):
        for k in range(segments.shape[0]):
            at = u(line * size + segments[k, 0])
            for i in range(u(segments[k, 1] - segments[k, 0])):
                new = total[at + i] + x[at + i]
                x[at + i] = new - total[at + i]
                total[at + i] = new


@loops
def move_places(total, x, at, n):
    """total = x, and x = 0, in n places."""
    at = u(at)
    for i in range(u(n)):
        total[at + i] = x[at + i]
        x[at + i] = np.float32(0.0)


@jit
def move(total, x, segments, table, channels):
    """total = x, and x = 0."""
    size = table[0, QUARTER]
    for line in range(4 * channels):
        for k in range(segments.shape[0]):
            move_places(total, x, line * size + segments[k, 0], segments[k, 1] - segments[k, 0])


@loops
def clear(x, segments, table, channels):
    """x = 0 on the finest level."""
    size = table[0, QUARTER]
    for line in range(4 * channels):
        for k in range(segments.shape[0]):
            at = u(line * size + segments[k, 0])
            for i in range(u(segments[k, 1] - segments[k, 0])):
                x[at + i] = np.float32(0.0)


@inlined
def residual_at(b, diagonal, x, far, near):
    """b - A x in a place of the region, in float64, from the sums of its far and of its near neighbours."""
    residual = (np.float64(b) - np.float64(diagonal) * np.float64(x)) + (far + near)
    return residual if diagonal > np.float32(0.0) else 0.0


@loops
def residuals_at(b, x, diagonal, d_upper, d_lower, upper, lower, along, under, north, south, side, flank):
    """The two residuals of a colour in one place."""
    near = np.float64(x[along]) + np.float64(x[under])
    far_upper = np.float64(x[north]) + np.float64(x[side])
    far_lower = np.float64(x[south]) + np.float64(x[flank])
    return (
        residual_at(b[upper], diagonal[d_upper], x[upper], far_upper, near),
        residual_at(b[lower], diagonal[d_lower], x[lower], far_lower, near),
    )


@loops
def residual_of(b, x, diagonal, size, stride, plane, colour, at, n, keep):
    """b - A x in n places of the quarters of a colour, for whose names see `kernels.cycle`.

    With `keep` returns the bit pattern of the largest one; else b becomes what is computed.
    """
    d_upper, d_lower = u(colour * size + at), u((3 - colour) * size + at)
    upper, lower = u(plane + colour * size + at), u(plane + (3 - colour) * size + at)
    along, under = u(plane + (colour ^ 1) * size + at), u(plane + (colour ^ 2) * size + at)
    north, south = under - u(stride), along + u(stride)
    side = along - u(1) if colour == 0 else along + u(1)
    flank = under + u(1) if colour == 0 else under - u(1)
    largest = np.int64(0)
    if keep:
        for i in range(u(n)):
            one, other = residuals_at(
                b, x, diagonal, d_upper + i, d_lower + i, upper + i, lower + i, along + i, under + i,
                north + i, south + i, side + i, flank + i,
            )  # fmt: skip
            largest = largest_of(largest, largest_of(bits_of(one), bits_of(other)))
    else:
        for i in range(u(n)):
            b[upper + i], b[lower + i] = residuals_at(
                b, x, diagonal, d_upper + i, d_lower + i, upper + i, lower + i, along + i, under + i,
                north + i, south + i, side + i, flank + i,
            )  # fmt: skip
    return largest


@jit
def subtract_image(b, total, x, diagonal, segments, table, channels, keep):
    """b - A x on the finest level, in float64: it takes the place of b.

    With a `total` that is not empty x takes the place of that, and x = 0, as in `move`: each segment as soon as no
    residual that reads it is left.  With `keep` b stays, and the bit pattern of the largest absolute value among the
    red cells is returned.  What a black cell holds is part of its neighbours' residuals, and every iteration ends with
    the black ones.
    """
    stride, size, count = table[0, STRIDE], table[0, QUARTER], segments.shape[0]
    largest = np.int64(0)
    for channel in range(channels):
        plane, moved = 4 * channel * size, count if total.shape[0] == 0 else 0
        for k in range(count):
            at, n = segments[k, 0], segments[k, 1] - segments[k, 0]
            for colour in range(1 if keep else 2):
                bits = residual_of(b, x, diagonal, size, stride, plane, colour, at, n, keep)
                largest = largest_of(largest, bits)
            while moved <= k and (k + 1 == count or segments[moved, 1] + stride < segments[k + 1, 0]):
                first, places = segments[moved, 0], segments[moved, 1] - segments[moved, 0]
                for quarter in range(4):
                    move_places(total, x, plane + quarter * size + first, places)
                moved += 1
    return largest
