"""fpie, numba backend, its command line's defaults: equation solver, 5000 Jacobi sweeps, no stop rule.

Driven through the classes that its command line drives, with gradient="src" so that the problem is eq. (7).
"""

from __future__ import annotations

from time import perf_counter
from typing import Any

import numpy as np

from benchmarks.accuracy import Answer
from benchmarks.case import Case
from benchmarks.peers import Peer, Prepared, Promise, Scope, TooSlowError

Array = np.ndarray[Any, Any]

SWEEPS = 5000  # the default of its command line
TRIAL = 100  # sweeps from which the time of a whole run is extrapolated


def prepare(case: Case, limit: float) -> Prepared:
    from fpie.process import EquProcessor

    mask = case.region.astype(np.uint8) * 255

    def clone(sweeps: int) -> Array:
        processor = EquProcessor(gradient="src", backend="numba")
        processor.reset(case.source, mask, case.destination, (0, 0), (0, 0))
        picture, _error = processor.step(sweeps)
        return np.asarray(picture)

    clone(1)  # warm-up: compiles
    start = perf_counter()
    clone(TRIAL)
    expected = (perf_counter() - start) * SWEEPS / TRIAL
    if expected > limit:
        raise TooSlowError(expected)
    return Prepared(lambda: clone(SWEEPS), Answer)


PEERS = (
    Peer("fpie, numba, 5000 sweeps", Scope.CLONE, Promise.IMPROVEMENT, prepare, needs=("fpie", "numba")),
)
