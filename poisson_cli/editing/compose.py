"""The one pipeline behind every tool: crop, guidance, problem, solve, paste."""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from time import perf_counter
from typing import Any, Unpack

import numpy as np
from numpy.typing import NDArray

from poisson_cli.editing import tone
from poisson_cli.editing.guidance import Field
from poisson_cli.editing.placement import Placement
from poisson_cli.editing.solving import SolverOptions, solve
from solvers import PoissonProblem
from solvers.problem import Values


@dataclass(frozen=True)
class EditReport:
    """What an edit did.

    Attributes
    ----------
    tool : str
    rectangle : (row, column, height, width)
        Omega's bounding box on the destination.
    unknowns : int
        Pixels of Omega.
    solver, cycle : str, str or None
        What was asked for; ``method`` says what was done, which differs where a cycle stalled.
    method : str
    iterations : int
        Cycles or sweeps.
    tolerance, error_estimate : float
        Largest error allowed and estimated in any pixel, in levels.
    floating : bool
        True if no pixel was known, so that the mean of the first guess was kept.
    boundary_mismatch : tuple of float or None
        Per channel, the mean of |f* - g| over the boundary, in levels; None where no boundary pixel has a source.
    clipped : int
        Values that left the range of the picture and were clipped.
    seconds : dict
        Seconds per stage: guidance, solve, paste.
    """

    tool: str
    rectangle: tuple[int, int, int, int]
    unknowns: int
    solver: str
    cycle: str | None
    method: str
    iterations: int
    tolerance: float
    error_estimate: float
    floating: bool
    boundary_mismatch: tuple[float, ...] | None
    clipped: int
    seconds: dict[str, float]


@dataclass(frozen=True)
class Edit:
    """The edited picture, of the destination's shape and dtype, and the report."""

    image: NDArray[Any]
    report: EditReport


def compose(
    tool: str,
    destination: NDArray[Any],
    placement: Placement,
    source: Values | None,
    field: Field | None,
    **options: Unpack[SolverOptions],
) -> Edit:
    """Solves eq. (7) over Omega and pastes the solution.  Pixels outside Omega are copied, never computed.

    Parameters
    ----------
    destination : (H, W) or (H, W, C) array
        f*, of a depth that `tone` knows; not modified.
    placement : Placement
    source : array or None
        g under the window: working floats, shape and dtype as those of the destination there.
    field : callable or None
        Makes the guidance from f* and g under the window; None for v = 0.
    """
    seconds: dict[str, float] = {}
    region = placement.region
    inside = region
    if destination.ndim == 3:
        # As large as the values: numpy would otherwise walk a broadcast mask pixel by pixel, ten times slower.
        inside = np.repeat(region, destination.shape[2], axis=1).reshape(*region.shape, -1)

    with _timed(seconds, "guidance"):
        known = tone.to_working("destination", placement.on_destination(destination))
        if source is None:
            # What lies under the selection must not matter, not even in the last bit: begin at zero there.
            guess = known if region.all() else np.zeros((), known.dtype)
            guidance = None
            mismatch = None
        else:
            # Where nothing is known the solution keeps the guess's mean: the destination's, as everywhere at the rim.
            guess = source if not region.all() else source + (known.mean((0, 1)) - source.mean((0, 1)))
            guidance = field(known, source) if field is not None else None
            there = np.nonzero(placement.boundary() & placement.has_source())
            mismatch = _mean_mismatch(known[there], source[there], tone.level(destination.dtype))
        values = np.where(inside, guess, known)

    with _timed(seconds, "solve"):
        problem = PoissonProblem(region, values, guidance, level=tone.level(destination.dtype))
        result = solve(problem, **options)

    with _timed(seconds, "paste"):
        image = destination.copy()
        np.copyto(
            placement.on_destination(image), tone.to_storage(result.solution, destination.dtype), where=inside
        )
        # Known values are in range, so only values of Omega can be counted.
        clipped = tone.count_clipped(result.solution, destination.dtype)

    solver = options.get("solver", "multigrid")
    report = EditReport(
        tool=tool,
        rectangle=placement.rectangle,
        unknowns=result.unknowns,
        solver=solver,
        cycle=options.get("cycle", "F") if solver == "multigrid" else None,
        method=result.method,
        iterations=result.iterations,
        tolerance=result.tolerance,
        error_estimate=result.error_estimate,
        floating=result.floating,
        boundary_mismatch=mismatch,
        clipped=clipped,
        seconds=seconds,
    )
    return Edit(image, report)


def _mean_mismatch(known: Values, guess: Values, level: float) -> tuple[float, ...] | None:
    """Per channel, the mean of |f* - g| over boundary pixels (n[, C]), in levels; None if there are none."""
    if known.shape[0] == 0:
        return None
    mean = np.abs(known - guess).mean(0, dtype=np.float64) / level
    return tuple(float(m) for m in np.atleast_1d(mean))


@contextmanager
def _timed(seconds: dict[str, float], stage: str) -> Iterator[None]:
    start = perf_counter()
    yield
    seconds[stage] = perf_counter() - start
