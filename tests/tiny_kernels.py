"""A small library of kernels, for tests of how kernels are compiled, stored and loaded."""

import numpy as np

from solvers.native import Library

library = Library(
    modules=("tests.tiny_kernels",),
    ingredients=(),
    signatures={
        "scale": ["f4[:], f4[:,:], f4 -> f4", "f8[:], f8[:,:], f8 -> f8"],
        "extremes": ["f4[:] -> f4, f4"],
        "flatten": ["f8[:], f8[:,:,:], i8"],
        "every": ["b1[:], b1 -> b1"],
        "halve": ["f4[:]"],
        "smooth": ["f4[:], f4[:], f4[:] -> f4"],
    },
    further={"halve": ["f8[:]"]},
    options={"nogil": True, "error_model": "numpy", "boundscheck": False},
    home=__name__,
)


@library.jit()
def product(a, b):
    return a * b


@library.jit()
def scale(out, values, factor):
    """out = row sums of values * factor; returns the last."""
    for row in range(values.shape[0]):
        total = values.dtype.type(0)
        for col in range(values.shape[1]):
            total += product(values[row, col], factor)
        out[row] = total
    return out[values.shape[0] - 1]


@library.jit()
def extremes(values):
    low = high = values[0]
    for i in range(values.shape[0]):
        low, high = min(low, values[i]), max(high, values[i])
    return low, high


@library.jit()
def flatten(out, values, plane):
    line = values[plane].reshape(-1)
    for i in range(line.shape[0]):
        out[i] = np.sqrt(line[i])


@library.jit()
def every(flags, wanted):
    same = True
    for i in range(flags.shape[0]):
        same &= flags[i] == wanted
    return same


@library.jit()
def halve(values):
    for i in range(values.shape[0]):
        values[i] /= 2


@library.jit(independent=True, forceinline=True)
def add_neighbours(out, values, weights):
    """The arrays do not overlap."""
    one = np.uint64(1)
    for i in range(one, np.uint64(values.shape[0] - 1)):
        out[i] = weights[i] * (values[i - one] + values[i + one])


@library.jit()
def smooth(out, values, weights):
    add_neighbours(out, values, weights)
    return out[1]
