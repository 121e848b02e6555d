"""Between pictures and the layout, and between float32 and float64."""

import numpy as np

from solvers.kernels.policy import jit
from solvers.layout import QUARTER, STRIDE

ABS_BITS = np.int64(0x7FFFFFFFFFFFFFFF)  # all but the sign of a float64


@jit
def assemble(b, scratch64, values, across, down, rhs, weight, runs, table):
    """b = the residual of the problem at f: rhs_p + sum over q of v_pq - (f_p - f_q), summed in float64.

    values: (height, width, channels) f, known outside the region, first guess inside.  across, down: v on pixel pairs
    (`Guidance`); rhs: like values; arrays without rows stand for zeros.  scratch64: width * channels.

    Returns whether float32 held every value of b exactly.
    """
    height, width, channels = values.shape
    stride, size = table[0, STRIDE], table[0, QUARTER]
    guided, given = across.shape[0] > 0 or down.shape[0] > 0, rhs.shape[0] > 0
    inexact = 0
    for k in range(runs.shape[0]):
        for row in range(2 * runs[k, 0], min(2 * np.int64(runs[k, 0]) + 2, height)):
            low, high = 2 * np.int64(runs[k, 1]), min(2 * np.int64(runs[k, 2]), width)
            # Pixels of the row as one line of values, channels interleaved.
            n = (high - low) * channels
            line = scratch64[:n]
            own = values[row].reshape(-1)[low * channels : high * channels]
            if given:
                source = rhs[row].reshape(-1)[low * channels : high * channels]
                for i in range(n):
                    line[i] = source[i]
            else:
                for i in range(n):
                    line[i] = 0.0
            if row > 0:
                other = values[row - 1].reshape(-1)[low * channels : high * channels]
                for i in range(n):
                    line[i] += np.float64(other[i]) - own[i]
                if guided:
                    v = down[row - 1].reshape(-1)[low * channels : high * channels]
                    for i in range(n):
                        line[i] -= v[i]
            if row < height - 1:
                other = values[row + 1].reshape(-1)[low * channels : high * channels]
                for i in range(n):
                    line[i] += np.float64(other[i]) - own[i]
                if guided:
                    v = down[row].reshape(-1)[low * channels : high * channels]
                    for i in range(n):
                        line[i] += v[i]
            # Horizontal pairs: the first pixel of a row has no west, the last one no east neighbour.
            begin = channels if low == 0 else 0
            if n > begin:
                other = values[row].reshape(-1)[
                    low * channels + begin - channels : high * channels - channels
                ]
                here, sums = own[begin:], line[begin:]
                for i in range(n - begin):
                    sums[i] += np.float64(other[i]) - here[i]
                if guided:
                    v = across[row].reshape(-1)[
                        low * channels + begin - channels : high * channels - channels
                    ]
                    for i in range(n - begin):
                        sums[i] -= v[i]
            m = n - channels if high == width else n
            if m > 0:
                other = values[row].reshape(-1)[(low + 1) * channels : low * channels + channels + m]
                for i in range(m):
                    line[i] += np.float64(other[i]) - own[i]
                if guided:
                    v = across[row].reshape(-1)[low * channels : low * channels + m]
                    for i in range(m):
                        line[i] += v[i]
            for side in range(2):
                quarter = 2 * (row & 1) + side
                places = (high - low - side + 1) // 2
                o = quarter * size + (np.int64(runs[k, 0]) + 1) * stride + low // 2
                w = weight[o : o + places]
                for channel in range(channels):
                    a = o + 4 * channel * size
                    target = b[a : a + places]
                    values_of = line[side * channels + channel :]
                    for i in range(places):
                        total = values_of[2 * channels * i] if w[i] > 0 else 0.0
                        target[i] = total
                        inexact += np.float64(np.float32(total)) != total
    return inexact == 0


@jit
def add_solution(solution, total, x, weight, runs, table):
    """solution += total + x, summed in float64, on the region; solution: (height, width, channels)."""
    height, width, channels = solution.shape
    stride, size = table[0, STRIDE], table[0, QUARTER]
    for k in range(runs.shape[0]):
        for row in range(2 * runs[k, 0], min(2 * np.int64(runs[k, 0]) + 2, height)):
            low, high = 2 * np.int64(runs[k, 1]), min(2 * np.int64(runs[k, 2]), width)
            for side in range(2):
                quarter = 2 * (row & 1) + side
                places = (high - low - side + 1) // 2
                o = quarter * size + (np.int64(runs[k, 0]) + 1) * stride + low // 2
                w = weight[o : o + places]
                for channel in range(channels):
                    a = o + 4 * channel * size
                    t, own = total[a : a + places], x[a : a + places]
                    line = solution[row].reshape(-1)[(low + side) * channels + channel :]
                    for i in range(places):
                        u = np.float64(t[i]) + own[i]
                        if w[i] > 0 and u != 0.0:  # an unchanged -0.0 keeps its sign
                            line[2 * channels * i] += u


@jit
def fold(total, x, segments, table, channels):
    """total += x, in float32; x becomes what was really added, so that the residual can follow it exactly."""
    size = table[0, QUARTER]
    for line in range(4 * channels):
        for k in range(segments.shape[0]):
            a, n = line * size + segments[k, 0], segments[k, 1] - segments[k, 0]
            t, own = total[a : a + n], x[a : a + n]
            for i in range(n):
                new = t[i] + own[i]
                own[i] = new - t[i]
                t[i] = new


@jit
def subtract_image(b, scratch64, x, weight, diagonal, segments, table, channels, keep):
    """b - A x on the finest level, in float64; stored into b unless `keep`.  Returns the bit pattern of the
    largest absolute value.

    scratch64: as long as a segment.
    """
    stride, size = table[0, STRIDE], table[0, QUARTER]
    largest = np.int64(0)
    for channel in range(channels):
        plane = 4 * channel * size
        for quarter in range(4):
            for k in range(segments.shape[0]):
                at = segments[k, 0]
                n = segments[k, 1] - at
                r = scratch64[:n]
                o = quarter * size + at
                w, d, own = weight[o : o + n], diagonal[o : o + n], x[plane + o : plane + o + n]
                rhs = b[plane + o : plane + o + n]
                o = plane + (quarter ^ 2) * size + at - (0 if quarter & 2 else stride)
                north, south = x[o : o + n], x[o + stride : o + stride + n]
                o = plane + (quarter ^ 1) * size + at - (0 if quarter & 1 else 1)
                west, east = x[o : o + n], x[o + 1 : o + 1 + n]
                for i in range(n):
                    r[i] = (np.float64(north[i]) + south[i]) + (np.float64(west[i]) + east[i])
                for i in range(n):
                    r[i] = np.float64(rhs[i]) - np.float64(d[i]) * own[i] + r[i] if w[i] > 0 else 0.0
                bits = r.view(np.int64)
                for i in range(n):
                    largest = max(largest, bits[i] & ABS_BITS)
                if not keep:
                    for i in range(n):
                        rhs[i] = r[i]
    return largest
