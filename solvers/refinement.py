"""Iterating in float32, and being right in float64.

float32 halves the memory traffic of float64, which is what a sweep costs, but its rounding errors add up over a large
region: in multigrid they floor the error near 1e-6 of the solution for 60,000 unknowns, and near 1e-3 for 100 million.
So the solution is found in stages.  A stage solves A x = b in float32 until x is right to a few digits; then

    total <- total + x,    b <- b - A x in float64,    x <- 0

and the next stage solves for what is left, which is smaller by as many digits, and so are its rounding errors.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable

from solvers.correction import Correction
from solvers.result import Progress

# Levels: what a correction is taken to be as large as before anything is known of it.
FULL_SCALE = 255.0


def solve_in_stages(
    correction: Correction,
    iterate: Callable[[int], Iterable[float]],
    estimate: Callable[[list[float]], float],
    *,
    tolerance: float,
    max_iterations: int,
    floor: float,
    gain: float,
    ahead: Callable[[float, float], int],
    iterations_per_step: int = 1,
    progress: Progress | None = None,
) -> list[float]:
    """Runs an iteration on x until the stop rule of `tolerance` holds, or `max_iterations` are done.

    Returns the estimate of the error after each step, in levels.  The last one is that of the correction.

    Parameters
    ----------
    iterate : callable
        So many steps on ``correction.x``; tells as they go the largest change of any value by each.
    estimate : callable
        The error after the last of a stage's changes.
    tolerance : float
        In levels.
    floor : float
        Share of a stage's x below which rounding in float32 makes the iteration blind.
    gain : float
        A stage ends when the error is this share of its x; at least `floor`.
    ahead : callable
        How many steps it takes to get from an error to another one, as far as can be said; they are done in a row.
    iterations_per_step : int
        How many iterations (sweeps, cycles) a step is; `max_iterations` counts them.
    progress : callable, optional
        Told after each step: iterations done, estimated error in levels.
    """
    level = correction.problem.level
    history: list[float] = []
    changes: list[float] = []  # of this stage
    error = size = FULL_SCALE  # of x
    stage = 0
    allowed = max_iterations // iterations_per_step
    while len(history) < allowed:
        aim = max(gain * size, tolerance)
        steps = min(max(1, ahead(error, aim)), allowed - len(history))
        for change in iterate(steps):
            changes.append(change / level)
            size = changes[0]  # x began at zero: its first change is about its size
            error = max(estimate(changes), floor * size)
            history.append(error)
            if progress is not None:
                progress(len(history) * iterations_per_step, float(error))
        if not math.isfinite(changes[-1]):
            break
        if error <= tolerance and (correction.exact or stage > 0):
            error = max(error, correction.least_error() / level)
            if error <= tolerance:
                break
        if error <= max(gain * size, tolerance) and len(history) < allowed:
            correction.next_stage()
            changes.clear()
            size = error
            stage += 1
    if history:
        history[-1] = error
    return [float(error) for error in history]
