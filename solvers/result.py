"""What a solver returns."""

import math
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

from solvers.canvas import Values
from solvers.problem import PoissonProblem

Progress = Callable[[int, float], None]
"""Told while a solver iterates: cycles or sweeps so far, and the estimate of the largest error, in levels."""


class SolveResult(NamedTuple):
    """A solution of eq. (7) and how far it can be trusted.

    Attributes
    ----------
    solution : (H, W) or (H, W, C)
        dtype and shape of the problem's values, and bit for bit the same values outside the region.
    error_estimate : float
        Estimate of the largest error in any pixel, in levels.
    tolerance : float
        The error that was allowed, in levels.
    converged : bool
        Whether ``error_estimate <= tolerance``.  If not, the solution is the best so far.
    iterations : int
        Cycles, or sweeps; 0 if everything was solved directly.
    history : tuple of float
        The estimate after each cycle, or after each group of sweeps, in levels; one if there was none.
    method : str
        For example ``"multigrid F"``, ``"directly and by multigrid F"``, ``"directly"``, ``"directly and by sor"`` or
        ``"sor omega=1.97"``.
    unknowns : int
        Unknown pixels.
    floating : bool
        True if no pixel was known, so that the mean of the first guess was kept.
    error_bound : float or None
        Proven upper bound of the largest error in any pixel of `solution`, in levels, its rounding to the dtype
        included; see `solvers.certificate`.  None if it was not asked for (``certify``).  `converged` goes by the
        estimate.
    advice : str or None
        A way that would have been far faster.
    """

    solution: Values
    error_estimate: float
    tolerance: float
    converged: bool
    iterations: int
    history: tuple[float, ...]
    method: str
    unknowns: int
    floating: bool
    error_bound: float | None = None
    advice: str | None = None

    @classmethod
    def after(
        cls,
        history: Sequence[float],
        problem: PoissonProblem,
        solution: Values,
        *,
        tolerance: float,
        **other: Any,
    ) -> "SolveResult":
        """What was reached in the end; infinitely far from it if nothing was done."""
        error = history[-1] if history else math.inf
        return cls(
            solution=solution,
            error_estimate=error,
            tolerance=tolerance,
            converged=error <= tolerance,
            history=tuple(history),
            unknowns=problem.unknowns,
            floating=problem.floating,
            **other,
        )
