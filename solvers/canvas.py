"""Where the numbers of a problem come from, and where its solution goes.

A solver needs a problem's values twice only: when it writes down the right-hand side, and when it adds the correction
that it found.  In between they would be so much memory held for nothing, several times what the solver itself needs: a
picture of bytes is held as bytes, and becomes floating-point numbers in bands of a few rows, which stay in the cache
between one step and the next.  A `Canvas` does that; `Arrays` is the canvas of a problem that was given whole.
"""

from collections.abc import Callable, Iterator
from typing import Any, NamedTuple, Protocol, TypeVar

import numpy as np
from numpy.typing import NDArray

from solvers.kernels.scattered import add_at

Values = NDArray[np.float32] | NDArray[np.float64]

BAND = (
    1 << 16
)  # values in a band: 256 KiB of float32, so that a handful of such arrays stays in the second-level cache
FEWEST_ROWS = 16  # in a band: the rows above and below it, which are read twice, must stay few beside it


class Equations(NamedTuple):
    """The numbers in the equations of a band of rows.

    Attributes
    ----------
    first, end : int
        The band is rows first ... end - 1 of the image; `first` is even, and so is `end` unless it is the height.
    top : int
        The row of the image that the arrays begin with.  They reach one row beyond the band on both sides, or further,
        or to the edge of the image.
    values : (n, W, C) float32 or float64
        Known values where the region is False, first guess where it is True.
    across, down : (n, W - 1, C), (n - 1, W, C) float, or None for zeros
        v on pixel pairs; see `Guidance`.
    rhs : (n, W, C) float, or None for zeros
        What else is added: per pixel, the sum over its neighbours of v.
    """

    first: int
    end: int
    top: int
    values: Values
    across: Values | None = None
    down: Values | None = None
    rhs: Values | None = None


class Rim(NamedTuple):
    """All that the equations of an image hold, where the first guess and v are zero.

    Attributes
    ----------
    row, col : (n,) int64
        The known pixels with a neighbour in the region.
    values : (n, C) float32
        What they hold.
    """

    row: NDArray[np.int64]
    col: NDArray[np.int64]
    values: NDArray[np.float32]


# Adds the correction in place to rows (n, W, C) of the first guess, the first of which is the given row of the image.
Correct = Callable[[Values, int], None]

T = TypeVar("T")


class Share(Protocol):
    """Calls an operation for ranges of rows, ``operation(first, end)``, that make up the image: several at a time.

    `first` is even, and so is `end` unless it is the height.  Returns what the calls returned, from the top.
    """

    def __call__(self, operation: Callable[[int, int], T], /) -> list[T]:
        """Returns when all calls have."""


class Canvas(Protocol):
    """The numbers of a problem, (H, W, C) of them, in bands of rows.

    Several threads may ask for equations at the same time, each for rows of its own.
    """

    @property
    def shape(self) -> tuple[int, int, int]:
        """H, W, C."""

    @property
    def small_integers(self) -> bool:
        """Whether all values and all v are integers (or all halves of integers) below 2^18.

        float32 then holds every sum that an equation asks for exactly.
        """

    def equations(self, first: int, end: int) -> Iterator[Equations]:
        """The bands of rows first ... end - 1 of the image, from the top; asked for more than once.

        `first` is even, and so is `end` unless it is the height.  A band is done with when the next one is asked for.
        """

    def rim(self) -> Rim | None:
        """Instead of the equations, if these are small integers and all zero but for known values; else None."""

    def paint(self, correct: Correct, share: Share) -> NDArray[Any]:
        """The first guess, corrected: what the solver returns as its solution."""

    def paint_at(self, place: NDArray[np.int64], correction: NDArray[np.float64]) -> NDArray[Any]:
        """The same bits, where the correction is given pixel by pixel.

        Parameters
        ----------
        place : (n,) int64
            Row * width + column of the pixels of the region, ascending.
        correction : (n, C or more)
            What comes behind the channels is the solver's own.
        """


def bands(first: int, end: int, row: int, larger: int = 1) -> Iterator[tuple[int, int]]:
    """First and end row of each band of rows first ... end - 1, of `row` values each; `first` is even.

    The bands are so many times as large as usual.
    """
    rows = max(FEWEST_ROWS, larger * BAND // row & ~1)
    for top in range(first, end, rows):
        yield top, min(top + rows, end)


class Arrays:
    """The canvas of a problem that is given whole: one band.

    Attributes
    ----------
    values : (H, W) or (H, W, C)
    across, down, rhs : arrays or None
        As in `Equations`, with or without channels as `values` is.
    """

    small_integers = False  # nobody has looked

    def __init__(
        self,
        values: Values,
        across: Values | None = None,
        down: Values | None = None,
        rhs: Values | None = None,
    ) -> None:
        self.values, self.across, self.down, self.rhs = values, across, down, rhs

    @property
    def shape(self) -> tuple[int, int, int]:
        """H, W, C."""
        height, width, channels = with_channels(self.values).shape
        return height, width, channels

    def equations(self, first: int, end: int) -> Iterator[Equations]:
        """One band; its arrays are the whole image's."""
        v = (None if array is None else with_channels(array) for array in (self.across, self.down, self.rhs))
        yield Equations(first, end, 0, with_channels(self.values), *v)

    def rim(self) -> None:
        """Nobody has looked."""

    def paint(self, correct: Correct, share: Share) -> Values:
        """The values plus the correction, of the values' shape and dtype."""
        solution: Values = np.empty_like(self.values)

        def rows(first: int, end: int) -> None:
            solution[first:end] = self.values[first:end]
            correct(with_channels(solution)[first:end], first)

        share(rows)
        return solution

    def paint_at(self, place: NDArray[np.int64], correction: NDArray[np.float64]) -> Values:
        """The values plus the correction, of the values' shape and dtype."""
        solution: Values = np.empty_like(self.values, order="C")
        solution[:] = self.values
        add_at(with_channels(solution), correction, place, 0, len(place), 0)
        return solution


def gather(canvas: Canvas) -> Arrays:
    """All the numbers of a canvas at once."""
    if isinstance(canvas, Arrays):
        return canvas
    parts: dict[str, list[Values]] = {"values": [], "across": [], "down": [], "rhs": []}
    for band in canvas.equations(0, canvas.shape[0]):
        for name, part in parts.items():
            array = getattr(band, name)
            if array is not None:  # the band's own rows; a pair downwards is counted to its upper row
                part.append(array[band.first - band.top : band.end - band.top].copy())
    whole: dict[str, Any] = {name: np.concatenate(part) for name, part in parts.items() if part}
    return Arrays(**whole)


def with_channels(values: Values) -> Values:
    """(H, W, C) of (H, W) or (H, W, C); a view."""
    return values if values.ndim == 3 else values[:, :, np.newaxis]
