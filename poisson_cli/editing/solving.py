"""Which solver, and how exact: the options that every tool shares."""

from typing import Literal, TypedDict

from poisson_cli.errors import InputError, NotConverged
from solvers import DEFAULT_TOLERANCE, OptionError, PoissonProblem, SolveResult, solve_multigrid, solve_sor
from solvers.cycles import Cycle
from solvers.result import Progress

Solver = Literal["multigrid", "sor"]


class SolverOptions(TypedDict, total=False):
    """Keywords of every tool.

    solver : {"multigrid", "sor"}
        V-, F- or W-cycle multigrid, or Gauss-Seidel with successive over-relaxation.
    cycle : {"F", "V", "W"}
        Multigrid only.
    tolerance : float
        Largest error allowed in any pixel, in levels (1/255 of full scale).
    max_iterations : int or None
        Cycles or sweeps after which to give up.
    threads : int or None
        The result is the same, bit for bit, for any number.
    certify : bool
        Also prove an upper bound of the error in any pixel (before values are rounded to integers): ``error_bound``.
    progress : callable or None
        Called as the solver goes, with the cycles or sweeps so far and the estimated error in levels.
    """

    solver: Solver
    cycle: Cycle
    tolerance: float
    max_iterations: int | None
    threads: int | None
    certify: bool
    progress: Progress | None


def solve(
    problem: PoissonProblem,
    *,
    solver: Solver = "multigrid",
    cycle: Cycle = "F",
    tolerance: float = DEFAULT_TOLERANCE,
    max_iterations: int | None = None,
    threads: int | None = None,
    certify: bool = False,
    progress: Progress | None = None,
) -> SolveResult:
    """Solves a problem as the options say.

    Raises
    ------
    NotConverged
        If the error may still be above `tolerance` after `max_iterations`.
    InputError
        If an option makes no sense.
    """
    try:
        if solver == "multigrid":
            result = solve_multigrid(
                problem,
                cycle=cycle,
                tolerance=tolerance,
                max_iterations=max_iterations,
                threads=threads,
                certify=certify,
                progress=progress,
            )
        elif solver == "sor":
            result = solve_sor(
                problem,
                tolerance=tolerance,
                max_iterations=max_iterations,
                threads=threads,
                certify=certify,
                progress=progress,
            )
        else:
            raise OptionError(f"solver is {solver!r}, but must be 'multigrid' or 'sor'")
    except OptionError as error:
        raise InputError(str(error)) from error
    if not result.converged:
        unit = "cycles" if solver == "multigrid" else "sweeps"
        raise NotConverged(
            f"not converged: after {result.iterations} {unit} ({result.method}) the error may be "
            f"{result.error_estimate:.2g} levels, {tolerance:g} is allowed; allow more iterations or a larger "
            "tolerance" + ("" if solver == "multigrid" else ", or use multigrid")
        )
    return result
