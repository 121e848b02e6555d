"""Multigrid: V-, F- and W-cycles on a region of any shape; its narrow parts are solved directly."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from solvers import apart
from solvers.canvas import Correct, Values
from solvers.certificate import Solver, proven_error
from solvers.correction import Correction, corrected
from solvers.cycles import CYCLES, Cycle, Cycling
from solvers.memory import borrowed_arena
from solvers.narrow import NarrowSolution, split
from solvers.problem import OptionError, PoissonProblem
from solvers.refinement import solve_in_stages
from solvers.result import Progress, SolveResult
from solvers.spectrum import softness
from solvers.team import Team
from solvers.tolerance import (
    DEFAULT_TOLERANCE,
    check_iterations,
    check_tolerance,
    estimate,
    next_rate,
    rate,
)

# Contraction factors of F(1,1) lie near 0.07; below this one a measured factor is luck.
LEAST_RHO: dict[Cycle, float] = {"V": 0.12, "F": 0.10, "W": 0.10}
# What is expected of a region that nothing is known of, and how many cycles are run without looking.
TYPICAL_RHO = 0.06
LONGEST_RUN = 4
# A cycle is left out that is hardly needed: it can still be run.
FEWER = 0.25
# Until two changes can be compared, at first and in later stages.
FIRST_RHO = 0.25
NEXT_RHO = 0.12
# A proposal for a certificate is judged by what it proves, not by a tolerance.
ANY_TOLERANCE = float(np.finfo(np.float64).tiny)
# A cycle that contracts no better than this is replaced by a stronger one.
STALLING_RHO = 0.4

# A stage of float32 cycles gains this much, or what it can; see `solvers.refinement`.
STAGE_GAIN = 2e-3
# Rounding errors of float32 make cycles blind below this share of the solution, times the region's softness; measured.
ROUNDING = 6e-10
LARGEST_FLOOR = 0.05

MAX_CYCLES = 100


def solve_multigrid(
    problem: PoissonProblem,
    *,
    cycle: Cycle = "F",
    tolerance: float = DEFAULT_TOLERANCE,
    max_iterations: int | None = None,
    threads: int | None = None,
    certify: bool = False,
    progress: Progress | None = None,
    direct: bool = True,
) -> SolveResult:
    """Solves eq. (7) of Perez et al. 2003 by multigrid.

    Narrow parts of the region are solved directly, see `solvers.narrow`: no cycle is run for those.

    Parameters
    ----------
    problem : PoissonProblem
    cycle : {"F", "V", "W"}
        F contracts the error by 0.04 to 0.1 per cycle on nearly every shape of region.  V does so only on simple ones:
        where a cycle stalls, the solver goes on with the next stronger one, and the result's method says so.
    tolerance : float
        Largest error allowed in any pixel, in levels.
    max_iterations : int, optional
        Cycles after which to give up, 100 by default; the result then has ``converged`` False.
    threads : int, optional
        Threads to use; the solution is the same, bit for bit, for any number.
    certify : bool
        Also prove a bound of the error, ``error_bound``; about as dear as solving once more.
    progress : callable, optional
        Called after each cycle with the number of cycles and the estimated error in levels; once if there is none.
    direct : bool
        Whether narrow parts may be solved directly; without, cycles run on all of the region, to be looked at.

    Raises
    ------
    OptionError
        If an option makes no sense; it is a ValueError.
    """
    if cycle not in CYCLES:
        raise OptionError(f"cycle is {cycle!r}, but must be one of {', '.join(CYCLES)}")
    tolerance = check_tolerance(tolerance)
    max_iterations = check_iterations(max_iterations, MAX_CYCLES)

    with borrowed_arena() as arena, Team(threads, problem.unknowns * problem.channels) as team:
        narrow = split(problem, arena, tolerance) if direct else None
        if narrow is not None and len(narrow.place) == problem.unknowns:
            result = _without_cycles(narrow, tolerance, progress)
            return certified(result, problem, narrow.add_to, team) if certify else result
        error_of_narrow = 0.0 if narrow is None else narrow.error / problem.level
        region = problem.region if narrow is None else narrow.rest()
        solved = []
        for box in apart.boxes(region):
            part = apart.part_of(problem, region, box)
            correction = Correction.of(part, arena, team)
            cycling = Cycling(correction.hierarchy, cycle, problem.channels, team)
            history = _iterate(correction, cycling, tolerance, max_iterations, progress)
            solved.append(_Solved(box, correction, cycling.names, history))
        correct = apart.together(
            [(part.box, part.correction.adding()) for part in solved], problem.region.shape
        )
        if narrow is not None:
            correct = _both(correct, narrow.add_to)
        names = max((part.names for part in solved), key=len)
        result = SolveResult.after(
            [max(error, error_of_narrow) for error in _largest([part.history for part in solved])],
            problem,
            corrected(problem, correct, team),
            tolerance=tolerance,
            iterations=max(len(part.history) for part in solved),
            method=" and by ".join([*_how(narrow), f"multigrid {', then '.join(names)}"]),
        )
        return certified(result, problem, correct, team) if certify else result


class _Solved(NamedTuple):
    """A part of the region, see `solvers.apart`, and how it was solved."""

    box: apart.Box
    correction: Correction
    names: list[Cycle]
    history: list[float]


def _iterate(
    correction: Correction, cycling: Cycling, tolerance: float, max_iterations: int, progress: Progress | None
) -> list[float]:
    """Cycles until the error is estimated to be small enough; returns the estimates."""
    floor = min(max(ROUNDING, ROUNDING * softness(correction.hierarchy)), LARGEST_FLOOR)
    rates: list[float] = []
    known = len(cycling.names)

    def estimated_error(changes: list[float]) -> float:
        nonlocal known
        # A stronger cycle's first change is what the one before it left, and says nothing of how either contracts.
        observed = rate(changes) if len(cycling.names) == known else None
        known = len(cycling.names)
        if observed is not None:
            rates.append(observed)
            if observed > STALLING_RHO:
                cycling.strengthen()
            return estimate(changes[-1], max(LEAST_RHO[cycling.names[-1]], next_rate(rates)))
        # What a stage begins with is what the cycles before it were slow to find.
        return estimate(changes[-1], max(NEXT_RHO, *rates) if rates else FIRST_RHO)

    def cycles_ahead(error: float, aim: float) -> int:
        """One cycle shows how large the error was, the others make it smaller."""
        expected = max([TYPICAL_RHO, *rates[-1:]])
        cautious = max(LEAST_RHO[cycling.names[-1]], expected)
        if rates:  # the estimate was cautious
            error *= expected / cautious
        after_one = estimate(error, cautious)
        if not aim < after_one < math.inf or expected > STALLING_RHO:
            return 1
        needed = math.log(aim / after_one) / math.log(expected)
        return min(1 + math.ceil(needed - FEWER), LONGEST_RUN)

    return solve_in_stages(
        correction,
        lambda cycles: cycling.run(correction.x, correction.b, cycles),
        estimated_error,
        tolerance=tolerance,
        max_iterations=max_iterations,
        floor=floor,
        gain=max(STAGE_GAIN, 2 * floor),
        ahead=cycles_ahead,
        progress=progress,
    )


def _largest(histories: list[list[float]]) -> list[float]:
    """The largest estimate after each cycle; where a history ends, its last one goes on."""
    longest = max(len(history) for history in histories)
    return [max(history[min(k, len(history) - 1)] for history in histories) for k in range(longest)]


def _both(one: Correct, other: Correct) -> Correct:
    """Adds two corrections."""

    def add(guess: Values, top: int) -> None:
        one(guess, top)
        other(guess, top)

    return add


def _without_cycles(narrow: NarrowSolution, tolerance: float, progress: Progress | None) -> SolveResult:
    """The result where nothing is left to cycles."""
    problem, iterations = narrow.problem, narrow.sweeps
    error = narrow.error / problem.level
    if progress is not None:
        progress(iterations, error)
    solution = problem.canvas.paint_at(narrow.place, narrow.values)
    return SolveResult.after(
        [error],
        problem,
        solution,
        tolerance=tolerance,
        iterations=iterations,
        method=" and by ".join(_how(narrow)),
    )


def _how(narrow: NarrowSolution | None) -> list[str]:
    """How narrow parts were solved."""
    if narrow is None:
        return []
    return ["directly", "sor"] if narrow.sweeps else ["directly"]


def certified(result: SolveResult, problem: PoissonProblem, correct: Correct, team: Team) -> SolveResult:
    """The result with a proven bound of its error; `correct` is what it was made with."""
    precise = corrected(problem, correct, team, np.float64)
    bound = proven_error(problem, precise, result.solution, _propose(team.threads))
    return result._replace(error_bound=bound)


def _propose(threads: int) -> Solver:
    """A solver for `proven_error`."""

    def solution(problem: PoissonProblem, cycles: int) -> Values:
        return solve_multigrid(
            problem, tolerance=ANY_TOLERANCE, max_iterations=cycles, threads=threads
        ).solution

    return solution
