"""The correction to a first guess: what the solvers iterate on, held in float32, with its residual in float64."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from solvers.canvas import Correct, Values, with_channels
from solvers.hierarchy import Hierarchy, build_hierarchy
from solvers.kernels import exact as kernels
from solvers.kernels import pictures
from solvers.layout import Float32, field_size
from solvers.memory import Arena
from solvers.problem import PoissonProblem
from solvers.team import Team
from solvers.tolerance import LARGEST_ROW_SUM

T = TypeVar("T")


@dataclass
class Correction:
    """The correction u = total + x to a problem's first guess, with b = b_0 - A total; A u = b_0 is what is wanted.

    Attributes
    ----------
    arena : Arena
        Where the fields live.
    team : Team
        Who does the work here; no bit depends on how many they are.
    x, b : float32
        Fields of `channels` channels, on all levels of the hierarchy.
    exact : bool
        Whether b_0 is exact in float32, as it is for 8- and 16-bit pictures.  b then follows total by subtraction; else
        b is assembled anew, because a rounded b_0 has a solution of its own.
    """

    problem: PoissonProblem
    hierarchy: Hierarchy
    arena: Arena
    team: Team
    x: Float32
    b: Float32
    exact: bool = True
    _total: Float32 | None = field(default=None, init=False, repr=False)  # None: zero
    _pieces: list[NDArray[np.int64]] = field(init=False, repr=False)

    def __post_init__(self) -> None:
        h, channels = self.hierarchy, self.problem.channels
        self._pieces = self.team.pieces(h.finest_segments, 0, h.unknowns[0] * channels)

    @classmethod
    def of(cls, problem: PoissonProblem, arena: Arena, team: Team) -> Correction:
        """u = 0, with the right-hand side of the problem; it lives in the arena."""
        region, unknowns = problem.region, problem.unknowns
        if problem.floating:
            # The equations fix all but a constant.  One pixel is held, the constant is set at the end.
            region = region.copy()
            region[region.shape[0] // 2, region.shape[1] // 2] = False
            unknowns -= 1
        hierarchy = build_hierarchy(region, arena, team, screening=problem.screening, n_unknowns=unknowns)
        arena.reclaim()  # what was needed on the way there is 5 bytes per pixel
        channels, table = problem.channels, hierarchy.table
        correction = cls(
            problem,
            hierarchy,
            arena,
            team,
            x=arena.zeros(field_size(table, channels)),
            b=arena.zeros(field_size(table, channels)),
        )
        rim = problem.canvas.rim()
        if rim is None:
            correction.exact = correction.assemble()
        else:
            kernels.assemble_rim(correction.b, rim.values, rim.row, rim.col, hierarchy.weight, table)
        return correction

    def assemble(self, *, corrected: bool = False) -> bool:
        """b <- the problem's residual at the first guess, or at that + total; whether float32 held it exactly."""
        canvas, h = self.problem.canvas, self.hierarchy
        _, width, channels = canvas.shape
        total = self.total if corrected else self.x[:0]

        def rows(first: int, end: int) -> bool:
            line64 = np.empty((width + 1) * channels)
            exact = True
            for band in canvas.equations(first, end):
                v = [_or_nothing(array, band.values) for array in (band.across, band.down, band.rhs)]
                at = band.top, band.first, band.end
                where = h.weight, h.diagonal, _runs_of(h.finest_runs, band.first, band.end), h.table
                exact &= bool(kernels.assemble(self.b, line64, total, band.values, *v, *at, *where))
            return exact

        return all(shared_rows(self.problem, self.team, rows))

    @property
    def total(self) -> Float32:
        """What earlier stages found: a field of the finest level."""
        if self._total is None:
            self._total = self.arena.zeros(self._size)
        return self._total

    def next_stage(self) -> None:
        """total <- total + x, b <- b - A x, x <- 0."""
        where = self.hierarchy.table, self.problem.channels
        if self._total is None and self.exact and not self.problem.floating:
            self._total = self.arena.floats(self._size)  # nothing is read there but what is moved
            if len(self._pieces) == 1:
                self._residual(self._total)
                return
            self._residual(self._nothing)
            self.team.run(kernels.move, [(self._total, self.x, piece, *where) for piece in self._pieces])
            return
        self.team.run(kernels.fold, [(self.total, self.x, piece, *where) for piece in self._pieces])
        if self.exact:
            self._residual(self._nothing)
        else:
            self.assemble(corrected=True)
        self.team.run(kernels.clear, [(self.x, piece, *where) for piece in self._pieces])

    @property
    def finest(self) -> Float32:
        """The finest level of x."""
        return self.x[: self._size]

    @property
    def _size(self) -> int:
        """Length of the finest level of a field."""
        return field_size(self.hierarchy.table, self.problem.channels, levels=1)

    def least_error(self) -> float:
        """A lower bound of the largest error, from the true residual, in float64."""
        return self._residual(self._nothing, keep=True) / (LARGEST_ROW_SUM + self.problem.screening)

    @property
    def _nothing(self) -> Float32:
        return self.x[:0]

    def _residual(self, total: Float32, *, keep: bool = False) -> float:
        """See `kernels.exact.subtract_image`."""
        h = self.hierarchy

        def subtract(piece: NDArray[np.int64]) -> int:
            where = h.diagonal, piece, h.table, self.problem.channels
            return int(kernels.subtract_image(self.b, total, self.x, *where, keep))

        bits = max(self.team.run(subtract, [(piece,) for piece in self._pieces]))
        return float(np.int64(bits).view(np.float64))

    def solution(self) -> Values:
        """First guess + correction, as the problem's canvas paints it."""
        return corrected(self.problem, self.adding(), self.team)

    def adding(self) -> Addition:
        """What adds the correction to rows of the first guess."""
        return Addition(self)

    def _drift(self) -> NDArray[np.float64]:
        """The mean of the correction, per channel."""
        height, width, channels = self.problem.canvas.shape
        total, x = (u.reshape(channels, -1) for u in (self.total, self.finest))
        sums = total.sum(1, dtype=np.float64) + x.sum(1, dtype=np.float64)
        return np.asarray(sums / (height * width), np.float64)


class Addition:
    """What adds a correction to rows of the first guess; see `solvers.canvas.Correct`."""

    def __init__(self, correction: Correction) -> None:
        self._of = correction
        self._fields = correction.total, correction.x
        self._drift = correction._drift() if correction.problem.floating else None

    def __call__(self, guess: Values, top: int) -> None:
        """In place, to rows (n, W, C), the first of which is row `top` of the image."""
        h = self._of.hierarchy
        runs = _runs_of(h.finest_runs, top, top + len(guess))
        line = np.empty((guess.shape[1] + 1) * guess.shape[2], guess.dtype)
        pictures.add_solution(guess, line, *self._fields, top, runs, h.table)
        if self._drift is not None:
            guess -= self._drift.astype(guess.dtype)

    def round_into(
        self,
        picture: NDArray[Any],
        base: NDArray[Any],
        corners: NDArray[np.int64],
        largest: float,
        first: int,
        end: int,
    ) -> tuple[float, float]:
        """Rows first ... end of a picture of integers: where the region is, base + correction, rounded and clipped.

        The same as adding to float32 values of the base, and rounding those, but the values are never all there.

        Parameters
        ----------
        picture, base : (H, W, C) uint8
            The base holds the first guess.
        corners : (4,) int64
            Row and column where the image begins on the picture, and on the base.
        largest : float
            Where to clip.
        first, end : int
            `first` is even.

        Returns
        -------
        float, float
            How many values were clipped, and how far the furthest left the range.
        """
        assert self._drift is None, "where only a constant is known the first guess is no picture"
        h, region = self._of.hierarchy, self._of.problem.region
        room = (region.shape[1] + 1) * picture.shape[2]
        scratch = np.empty(room, np.uint8), np.empty(room, np.float32)
        where = first, end, _runs_of(h.finest_runs, first, end), h.table
        clipped, furthest = pictures.round_solution(
            picture, base, *scratch, *self._fields, region, corners, largest, *where
        )
        return float(clipped), float(furthest)


def corrected(
    problem: PoissonProblem, correct: Correct, team: Team, dtype: type[np.floating[Any]] | None = None
) -> Values:
    """What the problem's canvas makes of a correction; with `dtype`: first guess + correction, of that dtype.

    Of a problem that was given as arrays both are its values plus the correction, the same bits outside the region.
    """

    def share(operation: Callable[[int, int], T]) -> list[T]:
        return shared_rows(problem, team, operation)

    if dtype is None:
        return problem.canvas.paint(correct, share)
    solution: Values = problem.values.astype(dtype)
    guess = with_channels(solution)
    share(lambda first, end: correct(guess[first:end], first))
    return solution


def shared_rows(problem: PoissonProblem, team: Team, operation: Callable[[int, int], T]) -> list[T]:
    """The operation on rows first ... end - 1 of the image, for ranges that make it up; see `canvas.Share`."""
    height, width, channels = problem.canvas.shape
    return team.run(operation, team.rows(height, height * width * channels))


def _runs_of(runs: NDArray[np.int32], first: int, end: int) -> NDArray[np.int32]:
    """Those of the runs that hold pixels of rows first ... end of the image; a run is two rows high."""
    low, high = runs[:, 0].searchsorted((first // 2, (end + 1) // 2))
    return runs[low:high]


def _or_nothing(values: Values | None, like: Values) -> Values:
    """An array without rows in place of None: kernels take arrays only, and are compiled for arrays of one dtype."""
    return np.zeros((0, 0, 0), like.dtype) if values is None else with_channels(values)
