"""Narrow parts of a region, solved pixel by pixel: no grids, no cycles, nothing proportional to the bounding box.

Multigrid sweeps whole vectors of a grid's rows.  In a stroke two pixels wide, or a speck of dust, most of such a vector
is known already, and the sweeps cost ten times what they cost in a disk.  There it is cheaper to take only the unknowns
that there are, one by one, with all channels of one as a vector.

A part of a few pixels across is eliminated in reading order, and all that is in use at a time is a small full matrix.
Any other is relaxed: known pixels are near everywhere, so that twenty or thirty sweeps of over-relaxation solve it,
however large it is.  Where it is wider than was thought, that is seen after some sweeps, and it is left to multigrid.

Known pixels separate the parts of a region, so that each may be solved in its own way: `split` takes out what is narrow
enough, and leaves the rest to multigrid.  The error of a solution x is bounded by max|b - A x| max A^-1 1, both of
which are at hand: A z = 1 is solved beside A x = b, as one more channel.
"""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from solvers.canvas import Values, with_channels
from solvers.kernels import narrow as kernels
from solvers.kernels import scattered
from solvers.layout import FOUR
from solvers.memory import Arena
from solvers.problem import PoissonProblem

# Where this share of the places that multigrid sweeps is unknown, multigrid is the faster one: disks, noise.
WELL_FILLED = 0.45
# Mean breadth, in pixels, up to which a part counts as narrow.
NARROW = 6.0
# A call of a kernel is not to take longer than .2 s: Python hears signals only in between.
CALL = 20_000_000  # unknowns to sweep in a call, over and over,
LARGEST_PART = 2_000_000  # or to get ready for that,
LONG_CALL = 5_000_000  # and of a call that looks at each once
# Over-relaxation goes on until the bound of the error is this share of what is allowed.
PRECISION = 0.95

MOST_LANES = 1 << 31  # of all unknowns: they are numbered in 32 bits

ENOUGH = 32  # pairs of rows: no more, or not many more, are looked at to tell whether a region is sparse
WORDS = 256  # of the region that are looked at together
BAND = 1 << 20  # pixels of the region to look at in one go


class Parts(NamedTuple):
    """The connected parts of a set of unknowns.

    Attributes
    ----------
    place : (n,) int64
        Row * width + column of each unknown, in reading order: an unknown's number is its index here.
    near : (n, 4) int32
        Numbers of the north, west, east and south neighbour, or `layout.KNOWN`, or `layout.BEYOND` the image.
    colour : (n,) int32
        `layout.RED` or `layout.BLACK`, as on a chessboard.
    order, rank : (n,) int32
        Numbers of the unknowns, part by part; where a number stands among them.
    starts : (n_parts + 1,) int32
        Where each part begins in `order`.
    part : (n,) int32
        The number of an unknown's part.
    pairs : (n_parts,) int32
        Pairs of neighbours in each part.
    """

    place: NDArray[np.int64]
    near: NDArray[np.int32]
    colour: NDArray[np.int32]
    order: NDArray[np.int32]
    rank: NDArray[np.int32]
    starts: NDArray[np.int32]
    part: NDArray[np.int32]
    pairs: NDArray[np.int32]

    @classmethod
    def of(cls, place: NDArray[np.int64], shape: tuple[int, int], arena: Arena) -> "Parts":
        """Those of the unknowns at these places of an image of this height and width; they live in the arena."""
        n = len(place)
        near = arena.integers(n, 4)
        part, colour, order, rank, pairs, starts = (arena.integers(size) for size in (n, n, n, n, n, n + 1))
        last, count = np.full(shape[1], -1, np.int32), 0
        for call in _calls(n):
            scattered.link(near, part, colour, last, place, *shape, *call)
        for call in _calls(n):
            count = scattered.number_parts(part, starts, pairs, near, count, *call)
        starts = starts[: count + 1]
        scattered.sort_parts(order, rank, arena.integers(count), part, starts)
        return cls(place, near, colour, order, rank, starts, part, pairs[:count])

    @property
    def sizes(self) -> NDArray[np.int32]:
        """Unknowns of each part."""
        return np.diff(self.starts)

    def unknowns_of(self, chosen: NDArray[np.bool_]) -> NDArray[np.bool_]:
        """Which unknowns belong to the chosen parts."""
        return chosen[self.part]

    @property
    def narrow(self) -> NDArray[np.bool_]:
        """Which parts are worth to be tried directly."""
        sizes = self.sizes
        breadth = sizes / (2.0 * sizes - self.pairs)  # twice the area by the perimeter
        return (sizes <= LARGEST_PART) & (breadth <= NARROW)


class NarrowSolution(NamedTuple):
    """The correction to the first guess in the narrow parts of a problem's region.

    Attributes
    ----------
    place : (n,) int64
        Row * width + column of the unknowns, ascending.
    values : (n, C or more) float64
        The correction there.
    error : float
        No value is further than this from the exact one, in the units of the problem: from the residual, or from what
        roundings leave of one.
    sweeps : int
        Sweeps of over-relaxation that it took; 0 if all was eliminated.
    """

    problem: PoissonProblem
    place: NDArray[np.int64]
    values: NDArray[np.float64]
    error: float
    sweeps: int

    def add_to(self, guess: Values, top: int) -> None:
        """Adds the correction to rows (n, W, C) of the first guess, the first of which is row `top` of the image."""
        low, high = _within(self.place, top, top + len(guess), guess.shape[1])
        scattered.add_at(guess, self.values, self.place, low, high, top)

    def rest(self) -> NDArray[np.bool_]:
        """The region without its narrow parts."""
        region = self.problem.region.copy()
        region.reshape(-1)[self.place] = False
        return region


def split(problem: PoissonProblem, arena: Arena, tolerance: float) -> NarrowSolution | None:
    """Solves the narrow parts of the region; None if none is worth it.  The solution lives in the arena.

    tolerance : in levels.
    """
    if problem.floating or problem.screening > 0 or not _worth_looking(problem.region):
        return None  # screened unknowns hardly feel each other: cycles contract fast
    if (problem.unknowns + 2) * _lanes(problem.channels) > MOST_LANES:
        return None
    height, width = problem.region.shape
    parts = Parts.of(places(problem.region, problem.unknowns, arena), (height, width), arena)
    narrow = parts.narrow
    if not narrow.all():
        if not narrow.any():
            return None
        parts = Parts.of(parts.place[parts.unknowns_of(narrow)], (height, width), arena)
    b = _right_hand_side(problem, parts, arena)
    values, solved, error, sweeps = _solve(
        b, problem.channels, parts, arena, PRECISION * tolerance * problem.level
    )
    place = parts.place
    if not solved.all():
        there = parts.unknowns_of(solved)
        place, values = place[there], values[there]
    return NarrowSolution(problem, place, values, error, sweeps) if len(place) else None


def _solve(
    b: NDArray[np.float64], channels: int, parts: Parts, arena: Arena, precision: float
) -> tuple[NDArray[np.float64], NDArray[np.bool_], float, int]:
    """x, the parts where it was cheap to find, a bound of its error there, and how many sweeps that took."""
    sizes = parts.sizes
    n, largest, lanes = len(b), int(sizes.max()), b.shape[1]
    slots, together = largest + 2, kernels.TOGETHER * lanes
    x = arena.doubles(n + 2, lanes)
    x[:2] = 0
    bounds, sweeps = arena.doubles(len(sizes)), arena.integers(len(sizes))
    scratch = (
        np.zeros(kernels.KEPT),
        *(arena.floats(lanes * slots) for _ in range(2)),
        arena.longs(2 * slots),
        arena.floats(slots),
        arena.integers(2, largest // kernels.CHUNK + 1),
        arena.longs(2 * kernels.MOST_SWEEPS + 2),
        arena.floats(together),
        arena.integers(together),
        arena.integers(n),
        arena.integers(largest),
        arena.doubles(lanes),
        arena.longs(lanes),
        arena.doubles(largest * (kernels.WINDOW + lanes)),
        arena.doubles(kernels.WINDOW * (kernels.WINDOW + lanes)),
    )
    where = b, parts.near, parts.colour, parts.order, parts.rank, parts.starts, channels
    part = 0
    while part < len(sizes):
        part = kernels.solve_parts(x, bounds, sweeps, *scratch, *where, part, len(sizes), precision, CALL)
    solved = sweeps >= 0
    return x[2:], solved, float(bounds.max(where=solved, initial=0)), int(sweeps.max(where=solved, initial=0))


def _right_hand_side(problem: PoissonProblem, parts: Parts, arena: Arena) -> NDArray[np.float64]:
    """The problem's residual at the first guess, (n, lanes); behind the channels comes the 1 of A z = 1."""
    canvas = problem.canvas
    height, width, channels = canvas.shape
    b = arena.doubles(len(parts.place), _lanes(channels))
    rim = canvas.rim()
    if rim is not None:
        scratch = arena.integers(3 * width), arena.floats((1 + len(rim.row)) * b.shape[1])
        scattered.sum_rim(b, *scratch, parts.place, parts.near, rim.values, rim.row, rim.col, width)
        return b
    for band in canvas.equations(0, canvas.shape[0]):
        low, high = _within(parts.place, band.first, band.end, width)
        if low < high:
            v = [_or_nothing(array, band.values) for array in (band.across, band.down, band.rhs)]
            for call in _calls(high - low):
                own = low + call[0], low + call[1]
                scattered.sum_pairs(b, parts.place, band.values, *v, height, band.top, *own)
    return b


def _lanes(channels: int) -> int:
    """Lanes of so many channels, and of A z = 1."""
    return -(-(channels + 1) // FOUR) * FOUR


def _within(place: NDArray[np.int64], first: int, end: int, width: int) -> tuple[int, int]:
    """Range of the unknowns in rows first ... end."""
    low, high = np.searchsorted(place, (first * width, end * width))
    return int(low), int(high)


def _or_nothing(values: Values | None, like: Values) -> Values:
    """An array without rows in place of None: kernels take arrays only, and are compiled for arrays of one dtype."""
    return np.zeros((0, 0, 0), like.dtype) if values is None else with_channels(values)


def places(region: NDArray[np.bool_], unknowns: int, arena: Arena) -> NDArray[np.int64]:
    """Row * width + column of each unknown, in reading order; so many there are."""
    pixels = region.reshape(-1)
    words = np.require(pixels[: len(pixels) & ~7].view(np.int64), requirements="A")
    place, marked = arena.longs(unknowns + 1), np.empty(WORDS, np.int64)
    count = 0
    for call in _calls(len(words) + (len(pixels) & 7 > 0)):
        count = scattered.locate(place, count, words, pixels, marked, *call)
    return place[:count]


def _calls(n: int) -> Iterator[tuple[int, int]]:
    """First and end of ranges that make up n."""
    for first in range(0, n, LONG_CALL):
        yield first, min(first + LONG_CALL, n)


def _worth_looking(region: NDArray[np.bool_]) -> bool:
    """Whether multigrid would sweep far more places than the region has; a look at the mask, here and there."""
    height, width = region.shape
    unknowns = places = 0
    step = max(1, height // (2 * ENOUGH))
    rows = max(1, BAND // (2 * step * width)) * 2 * step
    for first in range(0, height, rows):
        more = scattered.survey(region, first, min(first + rows, height), step)
        unknowns, places = unknowns + more[0], places + more[1]
    return bool(unknowns <= WELL_FILLED * places)  # all rows with unknowns may have been missed
