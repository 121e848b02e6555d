"""Red-black Gauss-Seidel with successive over-relaxation."""

from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from solvers.correction import Correction
from solvers.kernels.cycle import relax_over
from solvers.layout import BLACK, RED, Float32
from solvers.memory import borrowed_arena
from solvers.multigrid import certified
from solvers.problem import OptionError, PoissonProblem
from solvers.refinement import solve_in_stages
from solvers.result import Progress, SolveResult
from solvers.spectrum import best_omega
from solvers.team import Band, Team
from solvers.tolerance import (
    DEFAULT_TOLERANCE,
    check_iterations,
    check_tolerance,
    estimate,
    rate,
)

MAX_SWEEPS = 100_000

# The change of a single sweep says little: with omega near its best value all modes contract by omega - 1, and the
# restless short waves hide the long ones.  Changes are therefore taken over a step of SPAN / (2 - omega) sweeps, in
# which every mode contracts by exp(-SPAN) or so.
SPAN = 1.5

# On long thin regions a step may contract worse than any before it: seen up to 1.6 times beyond the estimate.
MARGIN = 2.0

# A stage of float32 sweeps gains this much; see `solvers.refinement`.
STAGE_GAIN = 1e-2

FIRST_RHO = 0.5  # until two steps can be compared
LEAST_RHO = 0.25

# A solve by multigrid takes as long as about so many sweeps, on regions of any shape and size,
MULTIGRID_IN_SWEEPS = 100
# and is recommended where it is this much faster, and that is more than a moment: a sweep visits a value in about 1 ns.
FAR_FASTER = 4
MOMENT = 5e8  # visits of a value

# Values that one compiled call visits at most, or about .1 s: Python answers an interrupt only between calls.
CALL = 1 << 26


def solve_sor(
    problem: PoissonProblem,
    *,
    omega: float | None = None,
    tolerance: float = DEFAULT_TOLERANCE,
    max_iterations: int | None = None,
    threads: int | None = None,
    certify: bool = False,
    progress: Progress | None = None,
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
    certify : bool
        Also prove a bound of the error, ``error_bound``, with the help of multigrid.
    progress : callable, optional
        Called after each few sweeps with the number of sweeps and the estimated error in levels.

    Raises
    ------
    OptionError
        If an option makes no sense; it is a ValueError.
    """
    if omega is not None and not 0 < omega < 2:
        raise OptionError(f"omega is {omega}, but must lie between 0 and 2")
    tolerance = check_tolerance(tolerance)
    max_iterations = check_iterations(max_iterations, MAX_SWEEPS)

    with borrowed_arena() as arena, Team(threads, problem.unknowns * problem.channels) as team:
        correction = Correction.of(problem, arena, team)
        h, channels = correction.hierarchy, problem.channels
        factor = np.float32(best_omega(h, team) if omega is None else omega)
        sweeps = min(max_iterations, max(1, round(SPAN / (2 - float(factor)))))
        x = correction.finest
        before = np.empty_like(x)
        half_sweeps = [
            [
                [
                    (x, correction.b, h.weight, h.finest_segments, h.table, channels, colour, factor, *part)
                    for part in parts
                ]
                for parts in _calls(h.finest_segments, channels, team)
            ]
            for colour in (RED, BLACK)
        ]

        def step(_: int) -> list[float]:
            before[:] = x
            for _ in range(sweeps):
                for half_sweep in half_sweeps:
                    for side_by_side in half_sweep:
                        team.run(relax_over, side_by_side)
            return [_largest_change(x, before)]

        rates = [FIRST_RHO]

        def estimated_error(changes: list[float]) -> float:
            observed = rate(changes)
            if observed is not None:
                rates.append(observed)
            # Waves swell and ebb: one fast step proves nothing, the slowest of the last few is believed.
            return MARGIN * estimate(changes[-1], max(LEAST_RHO, *rates[-3:]))

        history = solve_in_stages(
            correction,
            step,
            estimated_error,
            tolerance=tolerance,
            max_iterations=max_iterations,
            floor=min(_rounding(float(factor)), STAGE_GAIN),
            gain=STAGE_GAIN,
            ahead=lambda _error, _aim: 1,
            iterations_per_step=sweeps,
            progress=progress,
        )
        iterations = len(history) * sweeps
        result = SolveResult.after(
            history,
            problem,
            correction.solution(),
            tolerance=tolerance,
            iterations=iterations,
            method=f"sor omega={factor:.5g}",
            advice=_advice(iterations, problem.unknowns * channels),
        )
        return certified(result, problem, correction.adding(), team) if certify else result


def _calls(segments: NDArray[np.int64], channels: int, team: Team) -> list[list[Band]]:
    """Ranges of segments for the calls of a half sweep, those together that the team may do side by side."""
    sizes = segments[:, 1] - segments[:, 0]
    visits = 2 * channels * np.cumsum(sizes)  # of half the four quarters
    cuts = np.flatnonzero(np.diff(visits // (CALL * team.threads))) + 1
    edges = [0, *cuts.tolist(), len(segments)]
    return [team.bands(sizes[first:end], first) for first, end in pairwise(edges)]


def _largest_change(x: Float32, before: Float32) -> float:
    """max|x - before|; `before` is lost."""
    largest = np.float32(0)
    for first in range(0, x.size, CALL):
        change = before[first : first + CALL]
        np.abs(np.subtract(x[first : first + CALL], change, out=change), out=change)
        largest = np.maximum(largest, change.max())  # a NaN stays
    return float(largest)


def _advice(sweeps: int, values: int) -> str | None:
    """Whether to use multigrid instead, after so many sweeps over so many values."""
    faster = sweeps / MULTIGRID_IN_SWEEPS
    if faster < FAR_FASTER or sweeps * float(values) < MOMENT:
        return None
    return f"multigrid would be about {float(f'{faster:.1g}'):,.0f} times as fast"


def _rounding(omega: float) -> float:
    """Share of the solution that rounding errors of the sweeps may add up to: at most eps times the norm of A^-1 D.

    Sweeps cannot see this error, since it lies in the slow modes.  The norm is 1 / lambda, and omega tells lambda.
    """
    eigenvalue = (2 / omega - 1) ** 2 / 2
    return float(np.finfo(np.float32).eps) / 2 / eigenvalue
