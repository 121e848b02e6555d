"""The one pipeline behind every tool: crop, guidance, problem, solve, paste."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from time import perf_counter
from typing import TYPE_CHECKING, Unpack

from poisson_cli.editing.guidance import Factors, Field
from poisson_cli.editing.report import Edit, report_on
from poisson_cli.editing.rescaling import Unpainted, solve_in_range, without_guidance
from poisson_cli.editing.scene import Scene
from poisson_cli.editing.solving import SolverOptions, solve
from poisson_cli.editing.spaces import Fitted, Space
from poisson_cli.editing.window import Window
from poisson_cli.errors import InputError
from solvers import PoissonProblem, SolveResult
from solvers.canvas import Canvas
from solvers.problem import LARGEST_SCREENING

if TYPE_CHECKING:
    from poisson_cli.editing.transforms import Transform


def compose(
    tool: str,
    scene: Scene,
    field: Field,
    space: Space,
    *,
    then: Sequence[Transform | Factors] = (),
    screen: float = 0.0,
    robust: bool = False,
    rescale: bool = False,
    **options: Unpack[SolverOptions],
) -> Edit:
    """Solves eq. (7) over Omega and pastes the solution.  Pixels outside Omega are copied, never computed.

    Parameters
    ----------
    tool : str
        For the report.
    scene : Scene
        f*, g, and where they lie.
    field : Field
        Makes the guidance from f* and g under the window.
    space : Space
        Where the equations hold.
    then : sequence of Transform or Factors
        What is done to the guidance, in this order.
    screen, robust, rescale, **options
        As in `clone`.
    """
    if not 0 <= screen < LARGEST_SCREENING:
        raise InputError(f"screen is {screen}, but must be a number from 0 to {LARGEST_SCREENING:g}")
    start = perf_counter()
    for transform in then:
        field = field.then(transform if callable(transform) else transform.on(scene, field.of, space))
    source = scene.layer("source", space) if "source" in field.of else None

    def window_on(field: Field, screen: float) -> Window:
        drawn = screen > 0
        return Window(scene.destination, scene.placement, source, field, space, robust=robust, drawn=drawn)

    def solved(canvas: Canvas, screen: float) -> SolveResult:
        where = scene.placement
        problem = PoissonProblem.on_canvas(
            where.region, canvas, level=space.level, screening=screen, unknowns=where.unknowns
        )
        return solve(problem, **options)

    window = window_on(field, screen)
    if rescale:
        space = Fitted(space, *window.range())
        window = window_on(field, screen)
    mismatch = window.mismatch()
    preparing = perf_counter() - start
    if rescale:
        none = window_on(without_guidance(field), 0.0)
        result, scale = solve_in_range(
            window, lambda: solved(Unpainted(window), screen), lambda: solved(Unpainted(none), 0.0)
        )
    else:
        result, scale = solved(window, screen), 1.0
    guidance, paste = preparing + window.guidance_time.seconds, window.paste_time.seconds
    seconds = {"guidance": guidance, "solve": perf_counter() - start - guidance - paste, "paste": paste}
    report = partial(
        report_on,
        tool,
        result,
        options,
        mismatch,
        rectangle=scene.placement.rectangle,
        space=space.name,
        seconds=seconds,
        clipped=window.clipped,
        overshoot=window.overshoot,
        scale=scale,
    )
    return Edit(result.solution, report)
