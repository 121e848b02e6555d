"""The unit in which a solver's time is counted: one cold pass over its own x and b.

One pass reads b, reads x and writes x, once: `x += b` on two float32 arrays of as many values as there are
unknowns times channels, after both have been driven out of every cache.  A solver that touches its unknowns once
cannot be faster than this, whatever it computes; forty passes is what forty such sweeps from memory would cost.
"""

from __future__ import annotations

from time import perf_counter

import numpy as np

from benchmarks import machine
from benchmarks.timing import Timing


def pass_over(values: int, *, runs: int = 15) -> Timing:
    """Time `x += b` on `values` float32 values each, cold, several times."""
    x, b = np.zeros(values, np.float32), np.ones(values, np.float32)
    flush = np.zeros(min(4 * machine.last_level_cache(), 1 << 30) // 8)
    timing = Timing()
    for _ in range(runs):
        flush += 1.0  # reads and writes four times what the last cache holds
        start = perf_counter()
        np.add(x, b, out=x)
        timing.seconds.append(perf_counter() - start)
    if not (x == runs).all():
        raise ArithmeticError("the pass over x and b did not add up")
    return timing
