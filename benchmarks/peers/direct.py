"""scipy's sparse direct solver, SuperLU: one factorisation, three solves."""

from __future__ import annotations

from typing import Any

import numpy as np
import scipy.sparse as sp

from benchmarks import exact
from benchmarks.peers import linear

Array = np.ndarray[Any, Any]


def solve(matrix: sp.csr_matrix, b: Array, _tolerance: float) -> Array:
    return exact.factorised(matrix)(b)


PEERS = linear.peers("scipy sparse direct", solve, needs=("scipy",), stops=False)
