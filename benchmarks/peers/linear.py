"""What the general solvers of A w = b share: they are handed the same matrix, and stop at the same error.

Two peers come of each.  As a *clone* the clock sees everything that a user of such a library must do: build
the sparse matrix and the right-hand sides from the pictures (vectorised numpy, 4 conductances per pixel), set up,
solve three channels, add the source, round, paste.  As a *solve* it sees set-up and three solves.
"""

from __future__ import annotations

from collections.abc import Callable
from time import perf_counter
from typing import Any

import numpy as np
import scipy.sparse as sp

from benchmarks.accuracy import Answer
from benchmarks.case import Case
from benchmarks.exact import LinearSystem
from benchmarks.peers import TARGET, Peer, Prepared, Promise, Scope, TooSlowError

Array = np.ndarray[Any, Any]
Method = Callable[[sp.csr_matrix, Array, float], Array]  # (A, b of shape (n, C), relative residual) -> w

TOLERANCES = tuple(
    10.0**-k for k in range(2, 13)
)  # tried in this order: the first that reaches TARGET is timed


def peers(name: str, method: Method, *, needs: tuple[str, ...], stops: bool = True) -> tuple[Peer, Peer]:
    """The clone and the solve by one method; `stops` is False for a method that takes no tolerance."""

    def prepare_clone(case: Case, limit: float) -> Prepared:
        tolerance = loosest(case, case.system, method, limit, stops)

        def run() -> tuple[Array, Array]:
            system = LinearSystem.of_clone(case.destination, case.source, case.region)
            values = system.source + method(system.matrix, system.right_hand_side, tolerance)
            return case.picture(values), values

        return Prepared(run, lambda result: Answer(*result))

    def prepare_solve(case: Case, limit: float) -> Prepared:
        system = case.system
        tolerance = loosest(case, system, method, limit, stops)
        matrix, b = system.matrix, system.right_hand_side

        def answer(w: Array) -> Answer:
            values = system.source + w
            return Answer(case.picture(values), values)

        return Prepared(lambda: method(matrix, b, tolerance), answer)

    return (
        Peer(name, Scope.CLONE, Promise.VALUES, prepare_clone, needs),
        Peer(name, Scope.SOLVE, Promise.VALUES, prepare_solve, needs),
    )


def loosest(case: Case, system: LinearSystem, method: Method, limit: float, stops: bool) -> float:
    """The loosest tolerance whose largest error, after clipping to the range, is at most `TARGET` levels."""
    matrix, b = system.matrix, system.right_hand_side
    wanted = np.clip(case.exact, 0, 255)
    for tolerance in TOLERANCES if stops else (0.0,):
        start = perf_counter()
        values = system.source + method(matrix, b, tolerance)
        if (took := perf_counter() - start) > limit:
            raise TooSlowError(took)
        if abs(np.clip(values, 0, 255) - wanted).max() <= TARGET:
            return tolerance
    raise ArithmeticError(f"no tolerance reaches {TARGET} levels")
