"""The correction to a first guess: what the solvers iterate on, held in float32, with its residual in float64."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from solvers.hierarchy import Hierarchy, build_hierarchy
from solvers.kernels import exact as kernels
from solvers.layout import Float32, field_size
from solvers.memory import Arena
from solvers.problem import PoissonProblem, Values
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
        hierarchy = build_hierarchy(region, arena)
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

    def assemble(self) -> bool:
        """b <- the problem's residual at the first guess + total; whether float32 holds it exactly."""
        problem, h = self.problem, self.hierarchy
        values = _with_channels(problem.values)
        if self.total.any():
            values = values.astype(np.float64)
            kernels.add_solution(
                values, self.total, np.zeros_like(self.total), h.weight, h.finest_runs, h.table
            )
        nothing = np.zeros((0, 0, 0), values.dtype)
        across = down = rhs = nothing
        if problem.guidance is not None:
            across, down = _with_channels(problem.guidance.across), _with_channels(problem.guidance.down)
        elif problem.rhs is not None:
            rhs = _with_channels(problem.rhs)
            if problem.floating:
                rhs = rhs - rhs.mean((0, 1))  # a natural condition all round has a solution only then
        scratch64 = np.empty(values.shape[1] * values.shape[2])
        return bool(
            kernels.assemble(self.b, scratch64, values, across, down, rhs, h.weight, h.finest_runs, h.table)
        )

    def next_stage(self) -> None:
        """total <- total + x, b <- b - A x, x <- 0."""
        h = self.hierarchy
        kernels.fold(self.total, self.x, h.finest_segments, h.table, self.problem.channels)
        if self.exact:
            self._residual(keep=False)
        else:
            self.assemble()
        self.x[: self.total.size] = 0

    def least_error(self) -> float:
        """A lower bound of the largest error, from the true residual, in float64."""
        return self._residual(keep=True) / LARGEST_ROW_SUM

    def _residual(self, *, keep: bool) -> float:
        h = self.hierarchy
        scratch64 = np.empty(h.longest_segment)
        where = h.weight, h.diagonal, h.finest_segments, h.table, self.problem.channels
        bits = kernels.subtract_image(self.b, scratch64, self.x, *where, keep)
        return float(np.int64(bits).view(np.float64))

    def solution(self, dtype: type[np.floating[Any]] | None = None) -> Values:
        """The problem's values plus the correction, in their dtype or in `dtype`; outside the region the same bits."""
        problem, h = self.problem, self.hierarchy
        solution: Values = problem.values.astype(dtype or problem.values.dtype)
        view = _with_channels(solution)
        kernels.add_solution(view, self.total, self.x, h.weight, h.finest_runs, h.table)
        if problem.floating:
            drift = view.mean((0, 1), dtype=np.float64) - _with_channels(problem.values).mean(
                (0, 1), dtype=np.float64
            )
            view -= drift.astype(view.dtype)
        return solution


def _with_channels(values: Values) -> Values:
    return values if values.ndim == 3 else values[:, :, np.newaxis]
