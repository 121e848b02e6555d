"""pyamg: a hierarchy from the matrix, three solves, each accelerated by conjugate gradients: its fastest."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import scipy.sparse as sp

from benchmarks.peers import linear

Array = np.ndarray[Any, Any]


def ruge_stuben(matrix: sp.csr_matrix, b: Array, tolerance: float) -> Array:
    import pyamg

    return _solve(pyamg.ruge_stuben_solver, matrix, b, tolerance)


def smoothed_aggregation(matrix: sp.csr_matrix, b: Array, tolerance: float) -> Array:
    import pyamg

    return _solve(pyamg.smoothed_aggregation_solver, matrix, b, tolerance)


def _solve(
    hierarchy: Callable[[sp.csr_matrix], Any], matrix: sp.csr_matrix, b: Array, tolerance: float
) -> Array:
    np.random.seed(0)  # noqa: NPY002 - its spectral radii are estimated from numpy's global random numbers
    levels = hierarchy(matrix)
    return np.stack([levels.solve(column, tol=tolerance, accel="cg") for column in b.T], axis=1)


PEERS = (
    *linear.peers("pyamg Ruge-Stuben + CG", ruge_stuben, needs=("pyamg",)),
    *linear.peers("pyamg smoothed aggregation + CG", smoothed_aggregation, needs=("pyamg",)),
)
