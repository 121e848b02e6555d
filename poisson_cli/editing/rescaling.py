"""Fitting a result into the range of its picture without clipping.

A colour of which only some channels leave the range loses as much saturation as it must (`spaces.Fitted`): if contrast
were taken away until the most saturated pixel fits, next to nothing would be left of most pictures.  So it is luminance
that has to fit.

With the guidance multiplied by s the solution of eq. (7) is m + s (f - m), where f is the solution with all of the
guidance, and m, the membrane, that with none.  m obeys the maximum principle: it lies between the known values, and so
in range.  The largest s <= 1 that keeps all of the luminance in range thus exists, and the result is as seamless as f
is.  (If f is screened this is no solution of screened equations, but as seamless.)

In Lab the luminance of m may leave the range all the same, since the gamut is not convex: pixels at which it does have
no say, and are clipped.

f and m are held whole, unlike anything else in an edit.
"""

from collections.abc import Callable
from typing import NamedTuple, TypeVar

import numpy as np
from numpy.typing import NDArray

from poisson_cli.editing.guidance import Field
from poisson_cli.editing.layers import Band
from poisson_cli.editing.spaces import Space
from poisson_cli.editing.window import Window
from solvers import Guidance, SolveResult
from solvers.canvas import Correct, Share, Values

HALVINGS = 40

T = TypeVar("T")


def without_guidance(field: Field) -> Field:
    """The field with v = 0, sought from the same picture a."""
    nothing = np.zeros((1, 1, 1), np.float32)  # in float64 too
    return field.then(lambda band: Guidance(nothing, nothing))


def solve_in_range(
    window: Window, solve: Callable[[], SolveResult], solve_membrane: Callable[[], SolveResult]
) -> tuple[SolveResult, float]:
    """The solution painted within the range of the picture, and s.

    Parameters
    ----------
    window : Window
        What is painted on, in a space that is `spaces.Fitted`.
    solve, solve_membrane : callable
        Solve, unpainted, with all of the guidance and with none; the second is asked for only where it is needed.
    """
    whole = solve()
    image = window.paint(_put(whole.solution), _at_once(window))
    if window.overshoot == 0:
        return whole._replace(solution=image), 1.0
    none = solve_membrane()
    scale = largest_scale(window, whole.solution, none.solution)
    if scale < 1:
        image = window.paint(_put(scaled(whole.solution, none.solution, scale)), _at_once(window))
    bounds = [result.error_bound for result in (whole, none) if result.error_bound is not None]
    error = max(whole.error_estimate, none.error_estimate)
    # A mean of both solutions has no larger an error than the worse one.
    return whole._replace(solution=image, error_estimate=error, error_bound=max(bounds, default=None)), scale


def _at_once(window: Window) -> Share:
    """All rows in one go."""

    def share(operation: Callable[[int, int], T]) -> list[T]:
        return [operation(0, window.shape[0])]

    return share


def _put(values: Values) -> Correct:
    """A correction that makes the solution these values."""

    def put(rows: Values, top: int) -> None:
        rows[:] = values[top : top + len(rows)]

    return put


class Unpainted:
    """A window whose solution is handed over as working values, (h, w, C)."""

    def __init__(self, window: Window) -> None:
        self._window = window
        self.shape = window.shape
        self.small_integers = window.small_integers
        self.equations = window.equations
        self.rim = window.rim

    def paint_at(self, place: NDArray[np.int64], correction: NDArray[np.float64]) -> Values:
        """The same of a correction to single pixels."""
        solution = self.paint(lambda rows, top: None, _at_once(self._window))
        solution.reshape(-1, self.shape[2])[place] += correction[:, : self.shape[2]]
        return solution

    def paint(self, correct: Correct, share: Share) -> Values:
        """The solution before it becomes stored values."""
        solution = np.empty(self.shape, self._window.space.dtype)

        def rows(first: int, end: int) -> None:
            for low, high, layers in self._window.bands(first, end):
                values, _, _ = self._window.guess(Band(*layers, low, high))
                correct(values, low)
                solution[low:high] = values

        share(rows)
        return solution


def largest_scale(window: Window, f: Values, m: Values) -> float:
    """The largest s <= 1 for which m + s (f - m) stays in range in all of Omega."""
    low, high = window.range()
    leaving = []
    for first, end, layers in window.bands(0, len(f)):
        _, before, stored = window.guess(Band(*layers, first, end))
        there = window.region[first:end]
        parts = [
            None if part is None else part[there] for part in (f[first:end], m[first:end], before, stored)
        ]
        pixels = _Pixels(window.space, *parts)  # type: ignore[arg-type]
        leaving.append(pixels.only(~pixels.within(1.0, low, high) & pixels.within(0.0, low, high)))
    lower, upper = 0.0, 1.0
    if not any(len(pixels.f) for pixels in leaving):
        return 1.0
    for _ in range(HALVINGS):
        middle = (lower + upper) / 2
        if all(pixels.within(middle, low, high).all() for pixels in leaving):
            lower = middle
        else:
            upper = middle
    return lower


def scaled(f: Values, m: Values, scale: float) -> Values:
    """m + s (f - m), s as a number of the same type as f."""
    return m + f.dtype.type(scale) * (f - m)


class _Pixels(NamedTuple):
    """f and m in single pixels, (n, C), and what `Space.to_stored` must know of them."""

    space: Space
    f: Values
    m: Values
    before: Values | None
    stored: Values | None

    def within(self, scale: float, low: float, high: float) -> NDArray[np.bool_]:
        """Which of them are in range with this scale."""
        # The very arithmetic that paints them, so that what is in range here is in range there.
        working = self.f if scale == 1 else scaled(self.f, self.m, scale)
        values = self.space.to_stored(working, self.before, self.stored)
        return np.asarray(((values >= low) & (values <= high)).all(-1))

    def only(self, chosen: NDArray[np.bool_]) -> "_Pixels":
        """Some of them."""
        parts = (
            None if part is None else part[chosen] for part in (self.f, self.m, self.before, self.stored)
        )
        return _Pixels(self.space, *parts)  # type: ignore[arg-type]
