"""The one pipeline behind every tool: crop, guidance, problem, solve, paste."""

from time import perf_counter
from typing import Any, Unpack

from numpy.typing import NDArray

from poisson_cli.editing import tone
from poisson_cli.editing.guidance import Field
from poisson_cli.editing.layers import Layer
from poisson_cli.editing.placement import Placement
from poisson_cli.editing.report import Edit, EditReport
from poisson_cli.editing.solving import SolverOptions, solve
from poisson_cli.editing.window import Window
from solvers import PoissonProblem


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
    window.seconds["guidance"] = perf_counter() - start
    problem = PoissonProblem.on_canvas(placement.region, window, level=tone.level(destination.dtype))
    result = solve(problem, **options)
    solving = perf_counter() - start - sum(window.seconds.values())
    seconds = {"guidance": window.seconds["guidance"], "solve": solving, "paste": window.seconds["paste"]}

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
