"""Red-black Gauss-Seidel with successive over-relaxation."""

import numpy as np

from solvers.correction import Correction
from solvers.kernels.cycle import BLACK, RED, relax_over
from solvers.memory import borrowed_arena
from solvers.problem import OptionError, PoissonProblem
from solvers.refinement import solve_in_stages
from solvers.result import SolveResult
from solvers.spectrum import best_omega
from solvers.tolerance import (
    DEFAULT_TOLERANCE,
    check_iterations,
    check_tolerance,
    error_bound,
    rate,
)

MAX_SWEEPS = 100_000

# The change of a single sweep says little: with omega near its best value all modes contract by omega - 1, and the
# restless short waves hide the long ones.  Changes are therefore taken over a step of SPAN / (2 - omega) sweeps, in
# which every mode contracts by exp(-SPAN) or so.
SPAN = 1.5

# A stage of float32 sweeps gains this much; see `solvers.refinement`.
STAGE_GAIN = 1e-2

FIRST_RHO = 0.5  # until two steps can be compared
LEAST_RHO = 0.25


def solve_sor(
    problem: PoissonProblem,
    *,
    omega: float | None = None,
    tolerance: float = DEFAULT_TOLERANCE,
    max_iterations: int | None = None,
    threads: int | None = None,
) -> SolveResult:
    """Solves eq. (7) of Perez et al. 2003 by Gauss-Seidel iteration with successive over-relaxation.

    Parameters
    ----------
    problem : PoissonProblem
    omega : float, optional
        Relaxation factor, in (0, 2).  By default the best one for this region, see `solvers.spectrum`.
    tolerance : float
        Largest error allowed in any pixel, in levels.
    max_iterations : int, optional
        Sweeps after which to give up, 100,000 by default; the result then has ``converged`` False.
    threads : int, optional
        Threads to use; the solution is the same, bit for bit, for any number.

    Raises
    ------
    OptionError
        If an option makes no sense; it is a ValueError.
    """
    if omega is not None and not 0 < omega < 2:
        raise OptionError(f"omega is {omega}, but must lie between 0 and 2")
    tolerance = check_tolerance(tolerance)
    max_iterations = check_iterations(max_iterations, MAX_SWEEPS)
    if threads is not None and threads < 1:
        raise OptionError(f"threads is {threads}, but must be at least 1")

    with borrowed_arena() as arena:
        correction = Correction.of(problem, arena)
        h, channels = correction.hierarchy, problem.channels
        factor = np.float32(best_omega(h) if omega is None else omega)
        segments = h.finest_segments
        sweeps = min(max_iterations, max(1, round(SPAN / (2 - float(factor)))))
        x = correction.x[: correction.total.size]
        before = np.empty_like(x)

        def step() -> float:
            before[:] = x
            for _ in range(sweeps):
                for colour in (RED, BLACK):
                    relax_over(
                        x,
                        correction.b,
                        h.weight,
                        segments,
                        h.table,
                        channels,
                        colour,
                        factor,
                        0,
                        len(segments),
                    )
            return float(np.abs(np.subtract(x, before, out=before), out=before).max())

        rates = [FIRST_RHO]

        def estimate(changes: list[float]) -> float:
            observed = rate(changes)
            if observed is not None:
                rates.append(observed)
            # Waves swell and ebb: one fast step proves nothing, the slowest of the last few is believed.
            return error_bound(changes[-1], max(LEAST_RHO, *rates[-3:]))

        return solve_in_stages(
            correction,
            step,
            estimate,
            tolerance=tolerance,
            max_iterations=max_iterations,
            method=lambda: f"sor omega={factor:.5g}",
            floor=min(_rounding(float(factor)), STAGE_GAIN),
            gain=STAGE_GAIN,
            iterations_per_step=sweeps,
        )


def _rounding(omega: float) -> float:
    """Share of the solution that rounding errors of the sweeps may add up to: at most eps times the norm of A^-1 D.

    Sweeps cannot see this error, since it lies in the slow modes.  The norm is 1 / lambda, and omega tells lambda.
    """
    eigenvalue = (2 / omega - 1) ** 2 / 2
    return float(np.finfo(np.float32).eps) / 2 / eigenvalue
