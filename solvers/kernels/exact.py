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


@jit
def add_difference(sums, a, b):
    """sums += a - b; the arrays are at least as long as `sums`."""
    for i in range(sums.shape[0]):
        sums[i] += np.float64(a[i]) - np.float64(b[i])


@jit
def add_differences(sums, a, b, middle):
    """sums += (a - middle) + (b - middle)."""
    for i in range(sums.shape[0]):
        sums[i] += (np.float64(a[i]) - np.float64(middle[i])) + (np.float64(b[i]) - np.float64(middle[i]))


@jit
def set_differences(sums, a, b, middle):
    """sums = (a - middle) + (b - middle)."""
    for i in range(sums.shape[0]):
        sums[i] = (np.float64(a[i]) - np.float64(middle[i])) + (np.float64(b[i]) - np.float64(middle[i]))


@jit
def residual_of_row(line, values, across, down, rhs, y, is_first, is_last, low, high):
    """line = rhs_p + sum over q of v_pq - (f_p - f_q) for columns low ... high of row y of the arrays.

    line: channels interleaved, as in the arrays.  is_first, is_last: whether it is the image's first row, its last.
    """
    width, channels = values.shape[1:]
    start, stop = low * channels, high * channels
    n = stop - start
    # Columns from `begin` to `end` have a neighbour on both sides.
    begin, end = max(start, channels), max(min(stop, (width - 1) * channels), channels)
    west_edge, east_edge = low == 0 and width > 1, high == width and width > 1
    inner, first_pixel, last_pixel = (
        line[begin - start : end - start],
        line[:channels],
        line[n - channels : n],
    )

    row = values[y].reshape(-1)
    # A pixel beyond the edge, in whose place stands the pixel itself, makes no difference.
    north = values[y if is_first else y - 1].reshape(-1)
    south = values[y if is_last else y + 1].reshape(-1)
    set_differences(line[:n], north[start:], south[start:], row[start:])
    if end > begin:
        add_differences(inner, row[begin - channels :], row[begin + channels :], row[begin:])
    if west_edge:
        add_difference(first_pixel, row[channels:], row)
    if east_edge:
        add_difference(last_pixel, row[stop - 2 * channels :], row[stop - channels :])
    if across.shape[0] > 0:
        v = across[y].reshape(-1)
        if end > begin:
            add_difference(inner, v[begin:], v[begin - channels :])
        if west_edge:
            for i in range(channels):
                first_pixel[i] += v[i]
        if east_edge:
            for i in range(channels):
                last_pixel[i] -= v[stop - 2 * channels + i]
    if down.shape[0] > 0:
        if not is_first:
            v = down[y - 1].reshape(-1)[start:stop]
            for i in range(n):
                line[i] -= v[i]
        if not is_last:
            v = down[y].reshape(-1)[start:stop]
            for i in range(n):
                line[i] += v[i]
    if rhs.shape[0] > 0:
        v = rhs[y].reshape(-1)[start:stop]
        for i in range(n):
            line[i] += v[i]


@jit
def assemble(b, line, total, values, across, down, rhs, top, first, end, weight, diagonal, runs, table):
    """b = the problem's residual at f + total, for rows first ... end of the image (`first` is even).

    line: scratch for width * channels sums, float64.  total: as b, or empty for zeros.  values: (n, width, channels) f,
    known outside the region, first guess inside; row `top` of the image comes first.  across, down: v on pixel pairs
    (`Guidance`); rhs: like values; arrays without rows stand for zeros.  runs: those of the rows.

    Returns whether float32 held every value of b exactly.
    """
    channels = values.shape[2]
    height, width, stride, size = table[0, HEIGHT], table[0, WIDTH], table[0, STRIDE], table[0, QUARTER]
    step = 2 * channels
    inexact = 0
    for k in range(runs.shape[0]):
        begin = np.int64(runs[k, 0]) * 2
        low, high = np.int64(runs[k, 1]) * 2, min(np.int64(runs[k, 2]) * 2, width)
        for row in range(max(begin, first), min(begin + 2, end)):
            residual_of_row(
                line, values, across, down, rhs, row - top, row == 0, row == height - 1, low, high
            )
            for side in range(2):
                quarter = 2 * (row & 1) + side
                places = (high - low - side + 1) // 2
                at = (begin // 2 + 1) * stride + low // 2
                o = quarter * size + at
                w = weight[o : o + places]
                for channel in range(channels):
                    plane = 4 * channel * size
                    target = b[plane + o : plane + o + places]
                    sums = line[side * channels + channel :]
                    if total.shape[0] > 0:
                        d, t = diagonal[o : o + places], total[plane + o : plane + o + places]
                        q = plane + (quarter ^ 2) * size + at - (0 if quarter & 2 else stride)
                        north, south = total[q : q + places], total[q + stride : q + stride + places]
                        q = plane + (quarter ^ 1) * size + at - (0 if quarter & 1 else 1)
                        west, east = total[q : q + places], total[q + 1 : q + 1 + places]
                        for i in range(places):
                            image = np.float64(d[i]) * t[i] - (
                                (np.float64(north[i]) + south[i]) + (np.float64(west[i]) + east[i])
                            )
                            target[i] = sums[step * i] - image if w[i] > 0 else 0.0
                    else:
                        for i in range(places):
                            sum_ = sums[step * i] if w[i] > 0 else 0.0
                            target[i] = sum_
                            inexact += np.float32(sum_) != sum_
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
