"""What a tool returns: the edited picture, and what was done to it."""

from collections.abc import Callable
from functools import cached_property
from typing import Any, NamedTuple

from numpy.typing import NDArray

from poisson_cli.editing.boundary import NOTHING, Mismatch
from poisson_cli.editing.solving import SolverOptions
from solvers import SolveResult


class EditReport(NamedTuple):
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
        Per channel, the mean of |f* - g| over the boundary before anything is solved, in levels; None where no
        boundary pixel has a source, and for tools that import nothing.
    boundary_shift : tuple of float or None
        Per channel, the mean of f* - g there, in levels: what is added to g on the whole.
    clipped : int
        Values of integer pictures that left the range and were clipped.
    seconds : dict
        Seconds per stage: guidance, solve, paste; before them search (for a patch) or edges, where they were sought.
    error_bound : float or None
        Proven upper bound of the error in any pixel, before values were rounded to integers, in levels; None unless
        it was asked for (`certify`).
    advice : str or None
        A choice that would have been far faster.
    space : str
        The space that the equations were solved in.
    outliers : float or None
        Share of the boundary's pixels, 0..1, whose mismatch is an outlier (`boundary`); None where
        `boundary_mismatch` is.
    overshoot : float
        How far the solution left the range of the picture, in levels; 0 if nowhere.  Floats leave it unclipped.
    scale : float
        What the guidance was multiplied by to fit the range (`rescale`); 1 where that was not asked for or needed.
    offset : (row, column) or None
        `heal`: where the patch was taken from, relative to the selection.
    edge_share : float or None
        `flatten`: share of Omega's pixels, 0..1, that lie on an edge.
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
    space: str = "rgb"
    outliers: float | None = None
    overshoot: float = 0.0
    scale: float = 1.0
    offset: tuple[int, int] | None = None
    edge_share: float | None = None
    boundary_shift: tuple[float, ...] | None = None


class Edit:
    """The edited picture, and the report: what in it takes time is computed when somebody asks for it.

    Attributes
    ----------
    image : array
        Of the destination's shape and dtype.
    report : EditReport
    """

    def __init__(self, image: NDArray[Any], report: Callable[[], EditReport]) -> None:
        self.image = image
        self._report = report

    @cached_property
    def report(self) -> EditReport:
        """What was done."""
        return self._report()

    def reporting(self, seconds: dict[str, float], **more: Any) -> "Edit":
        """The same edit, with more in its report, and with seconds that were spent before it."""

        def report() -> EditReport:
            return self.report._replace(seconds={**seconds, **self.report.seconds}, **more)

        return Edit(self.image, report)

    def __reduce__(self) -> Any:
        return _edit_of, (self.image, self.report)


def _edit_of(image: NDArray[Any], report: EditReport) -> Edit:
    return Edit(image, lambda: report)


def report_on(
    tool: str, result: SolveResult, options: SolverOptions, mismatch: Mismatch = NOTHING, **done: Any
) -> EditReport:
    """A report of what the solver says, of what it was asked for, of the boundary, and of what else was done."""
    solver = options.get("solver", "multigrid")
    means, shift = mismatch.means()
    return EditReport(
        tool=tool,
        unknowns=result.unknowns,
        solver=solver,
        cycle=options.get("cycle", "F") if solver == "multigrid" else None,
        method=result.method,
        iterations=result.iterations,
        tolerance=result.tolerance,
        error_estimate=result.error_estimate,
        floating=result.floating,
        error_bound=result.error_bound,
        advice=result.advice,
        boundary_mismatch=means,
        boundary_shift=shift,
        outliers=mismatch.outliers(),
        **done,
    )
