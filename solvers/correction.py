"""The correction to a first guess: what the solvers iterate on, held in float32, with its residual in float64."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from solvers.canvas import Values, with_channels
from solvers.hierarchy import Hierarchy, build_hierarchy
from solvers.kernels import exact as kernels
from solvers.layout import Float32, field_size
from solvers.memory import Arena
from solvers.problem import PoissonProblem
from solvers.tolerance import LARGEST_ROW_SUM


@dataclass
class Correction:
    """The correction u = total + x to a problem's first guess, with b = b_0 - A total; A u = b_0 is what is wanted.

    Attributes
    ----------
    total, x, b : float32
        Fields of `channels` channels; x and b on all levels of the hierarchy, total on the finest.
    exact : bool
        Whether b_0 is exact in float32, as it is for 8- and 16-bit pictures.  b then follows total by subtraction; else
        b is assembled anew, because a rounded b_0 has a solution of its own.
    """

    problem: PoissonProblem
    hierarchy: Hierarchy
    total: Float32
    x: Float32
    b: Float32
    exact: bool = True

    @classmethod
    def of(cls, problem: PoissonProblem, arena: Arena) -> "Correction":
        """u = 0, with the right-hand side of the problem; it lives in the arena."""
        region = problem.region
        if problem.floating:
            # The equations fix all but a constant.  One pixel is held, the constant is set at the end.
            region = region.copy()
            region[region.shape[0] // 2, region.shape[1] // 2] = False
        hierarchy = build_hierarchy(region, arena, screening=problem.screening)
        arena.reclaim()  # what was needed on the way there is 5 bytes per pixel
        channels, table = problem.channels, hierarchy.table
        correction = cls(
            problem,
            hierarchy,
            total=arena.zeros(field_size(table, channels, levels=1)),
            x=arena.zeros(field_size(table, channels)),
            b=arena.zeros(field_size(table, channels)),
        )
        correction.exact = correction.assemble()
        return correction

    def assemble(self, *, corrected: bool = False) -> bool:
        """b <- the problem's residual at the first guess, or at that + total; whether float32 held it exactly."""
        canvas, h = self.problem.canvas, self.hierarchy
        _, width, channels = canvas.shape
        line = np.empty(width * channels, np.float32 if canvas.small_integers else np.float64)
        total = self.total if corrected else self.total[:0]
        exact = True
        for band in canvas.equations():
            v = [_or_nothing(array, band.values) for array in (band.across, band.down, band.rhs)]
            rows = band.top, band.first, band.end
            where = h.weight, h.diagonal, _runs_of(h.finest_runs, band.first, band.end), h.table
            exact &= bool(kernels.assemble(self.b, line, total, band.values, *v, *rows, *where))
        return exact

    def next_stage(self) -> None:
        """total <- total + x, b <- b - A x, x <- 0."""
        h = self.hierarchy
        where = h.finest_segments, h.table, self.problem.channels
        kernels.fold(self.total, self.x, *where)
        if self.exact:
            self._residual(keep=False)
        else:
            self.assemble(corrected=True)
        kernels.clear(self.x, *where)

    def least_error(self) -> float:
        """A lower bound of the largest error, from the true residual, in float64."""
        return self._residual(keep=True) / (LARGEST_ROW_SUM + self.problem.screening)

    def _residual(self, *, keep: bool) -> float:
        h = self.hierarchy
        scratch64 = np.empty(h.longest_segment)
        where = h.weight, h.diagonal, h.finest_segments, h.table, self.problem.channels
        bits = kernels.subtract_image(self.b, scratch64, self.x, *where, keep)
        return float(np.int64(bits).view(np.float64))

    def solution(self, dtype: type[np.floating[Any]] | None = None) -> Values:
        """What the problem's canvas makes of the correction; with `dtype`: first guess + correction, of that dtype.

        Of a problem that was given as arrays both are its values plus the correction, the same bits outside the region.
        """
        if dtype is None:
            return self.problem.canvas.paint(self.add_to)
        solution: Values = self.problem.values.astype(dtype)
        self.add_to(with_channels(solution), 0)
        return solution

    def add_to(self, guess: Values, top: int) -> None:
        """Adds the correction to rows (n, W, C) of the first guess, the first of which is row `top` of the image."""
        h = self.hierarchy
        runs = _runs_of(h.finest_runs, top, top + len(guess))
        line64 = np.empty(guess.shape[1] * guess.shape[2])
        kernels.add_solution(guess, line64, self.total, self.x, top, runs, h.table)
        if self.problem.floating:
            guess -= self._drift().astype(guess.dtype)

    def _drift(self) -> NDArray[np.float64]:
        """The mean of the correction, per channel."""
        height, width, channels = self.problem.canvas.shape
        total, x = (u[: self.total.size].reshape(channels, -1) for u in (self.total, self.x))
        sums = total.sum(1, dtype=np.float64) + x.sum(1, dtype=np.float64)
        return np.asarray(sums / (height * width), np.float64)


def _runs_of(runs: NDArray[np.int32], first: int, end: int) -> NDArray[np.int32]:
    """Those of the runs that hold pixels of rows first ... end of the image; a run is two rows high."""
    low, high = np.searchsorted(runs[:, 0], (first // 2, (end + 1) // 2))
    return runs[low:high]


def _or_nothing(values: Values | None, like: Values) -> Values:
    """An array without rows in place of None: kernels take arrays only, and are compiled for arrays of one dtype."""
    return np.zeros((0, 0, 0), like.dtype) if values is None else with_channels(values)
