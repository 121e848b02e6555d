"""Multigrid: V-, F- and W-cycles on a region of any shape."""

from solvers.correction import Correction
from solvers.cycles import CYCLES, Cycle, Cycling
from solvers.memory import borrowed_arena
from solvers.problem import OptionError, PoissonProblem
from solvers.refinement import solve_in_stages
from solvers.result import SolveResult
from solvers.tolerance import (
    DEFAULT_TOLERANCE,
    check_iterations,
    check_tolerance,
    error_bound,
    rate,
)

# Contraction factors of F(1,1) lie near 0.11; below this one a measured factor is luck.
LEAST_RHO = 0.15
# Until two changes can be compared.
FIRST_RHO = 0.25
# A cycle that contracts no better than this is replaced by a stronger one.
STALLING_RHO = 0.4

# A stage of float32 cycles gains this much; see `solvers.refinement`.
STAGE_GAIN = 2e-3

MAX_CYCLES = 100


def solve_multigrid(
    problem: PoissonProblem,
    *,
    cycle: Cycle = "F",
    tolerance: float = DEFAULT_TOLERANCE,
    max_iterations: int | None = None,
    threads: int | None = None,
) -> SolveResult:
    """Solves eq. (7) of Perez et al. 2003 by multigrid.

    Parameters
    ----------
    problem : PoissonProblem
    cycle : {"F", "V", "W"}
        F contracts the error by 0.1 per cycle on every shape of region.  V does so only on simple ones: where a
        cycle stalls, the solver goes on with the next stronger one, and the result's method says so.
    tolerance : float
        Largest error allowed in any pixel, in levels.
    max_iterations : int, optional
        Cycles after which to give up, 100 by default; the result then has ``converged`` False.
    threads : int, optional
        Threads to use; the solution is the same, bit for bit, for any number.

    Raises
    ------
    OptionError
        If an option makes no sense; it is a ValueError.
    """
    if cycle not in CYCLES:
        raise OptionError(f"cycle is {cycle!r}, but must be one of {', '.join(CYCLES)}")
    tolerance = check_tolerance(tolerance)
    max_iterations = check_iterations(max_iterations, MAX_CYCLES)
    if threads is not None and threads < 1:
        raise OptionError(f"threads is {threads}, but must be at least 1")

    with borrowed_arena() as arena:
        correction = Correction.of(problem, arena)
        cycling = Cycling(correction.hierarchy, cycle, problem.channels)
        rates = [FIRST_RHO]

        def estimate(changes: list[float]) -> float:
            observed = rate(changes)
            if observed is not None:
                rates.append(observed)
                if observed > STALLING_RHO:
                    cycling.strengthen()
            return error_bound(changes[-1], max(LEAST_RHO, *rates[-2:]))

        return solve_in_stages(
            correction,
            lambda: cycling.run(correction.x, correction.b),
            estimate,
            tolerance=tolerance,
            max_iterations=max_iterations,
            method=lambda: "multigrid " + ", then ".join(cycling.names),
            floor=min(1e-6 * max(1.0, problem.unknowns / 2e4), STAGE_GAIN / 2),  # as measured on disks
            gain=STAGE_GAIN,
        )
