"""scipy's conjugate gradients, without a preconditioner, from zero."""

from __future__ import annotations

from typing import Any

import numpy as np
import scipy.sparse as sp
import scipy.sparse.linalg as spla

from benchmarks.peers import linear

Array = np.ndarray[Any, Any]


def solve(matrix: sp.csr_matrix, b: Array, tolerance: float) -> Array:
    w = np.empty_like(b)
    for channel in range(b.shape[1]):
        w[:, channel], failed = spla.cg(matrix, b[:, channel], rtol=tolerance, atol=0.0, maxiter=100_000)
        if failed:
            raise ArithmeticError("scipy.sparse.linalg.cg did not converge")
    return w


PEERS = linear.peers("scipy CG", solve, needs=("scipy",))
