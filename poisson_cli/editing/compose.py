"""The one pipeline behind every tool: crop, guidance, problem, solve, paste."""

from dataclasses import dataclass
from time import perf_counter
from typing import Any, Unpack

from numpy.typing import NDArray

from poisson_cli.editing import tone
from poisson_cli.editing.guidance import Field
from poisson_cli.editing.layers import Layer
from poisson_cli.editing.placement import Placement
from poisson_cli.editing.solving import SolverOptions, solve
from poisson_cli.editing.window import Window
from solvers import PoissonProblem


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
    error_bound : float or None
        Proven upper bound of the error in any pixel, before values were rounded to integers, in levels; None unless
        it was asked for (`certify`).
    advice : str or None
        A choice that would have been far faster.
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
    error_bound: float | None = None
    advice: str | None = None


@dataclass(frozen=True)
class Edit:
    """The edited picture, of the destination's shape and dtype, and the report."""

    image: NDArray[Any]
    report: EditReport


def compose(
    tool: str,
    destination: NDArray[Any],
    placement: Placement,
    source: Layer | None,
    field: Field,
    **options: Unpack[SolverOptions],
) -> Edit:
    """Solves eq. (7) over Omega and pastes the solution.  Pixels outside Omega are copied, never computed.

    Parameters
    ----------
    destination : (H, W) or (H, W, C) array
        f*, of a depth that `tone` knows; not modified.
    placement : Placement
    source : Layer or None
        g under the window, with the destination's channels.
    field : Field
        Makes the guidance from f* and g under the window.
    """
    start = perf_counter()
    window = Window(destination, placement, source, field)
    mismatch = window.boundary_mismatch()
    preparing = perf_counter() - start
    problem = PoissonProblem.on_canvas(placement.region, window, level=tone.level(destination.dtype))
    result = solve(problem, **options)
    guidance, paste = preparing + window.guidance_time.seconds, window.paste_time.seconds
    solving = perf_counter() - start - guidance - paste
    seconds = {"guidance": guidance, "solve": solving, "paste": paste}

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
        clipped=window.clipped,
        seconds=seconds,
        error_bound=result.error_bound,
        advice=result.advice,
    )
    return Edit(result.solution, report)
