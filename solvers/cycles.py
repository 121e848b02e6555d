"""V-, F- and W-cycles, each written as the list of its steps.

A step names what to do and on which level:

    DOWN l        smooth level l, hand the residual's right-hand side to level l + 1
    UP l          add the interpolated solution of level l + 1, smooth level l
    TURN l        UP l, and DOWN l behind it
    COARSEST l    solve the coarsest level l exactly

"Smooth" is one red-black Gauss-Seidel sweep; its black half is over-relaxed after a correction.  A TURN is the end of
one cycle and the beginning of the next, or the same inside an F- or W-cycle: what would be two passes through memory is
one.  The recursion is unrolled here, in Python; a compiled kernel runs the list.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from functools import cache
from typing import Literal, NamedTuple, get_args

import numpy as np
from numpy.typing import NDArray

from solvers.hierarchy import Hierarchy
from solvers.kernels import cycle as kernels
from solvers.layout import FIRST_SEGMENT, LANES, STRIDE, Float32, aligned_zeros
from solvers.team import WORTH_SHARING, Band, Team

Cycle = Literal["V", "F", "W"]
CYCLES: tuple[Cycle, ...] = get_args(Cycle)

# How a cycle visits the level below: once, or twice in a row.
VISITS: dict[Cycle, tuple[Cycle, ...]] = {"V": ("V",), "F": ("F", "V"), "W": ("W", "W")}

# What to go on with where a cycle contracts badly.
STRONGER: dict[Cycle, Cycle] = {"V": "F", "F": "W"}


DOWN, UP, TURN, EXACT = "down", "up", "turn", "exact"

# The operations of a sweep that each kind of visit to a level consists of, see `kernels.cycle.sweep`.
N_OPERATIONS = 6
OPERATIONS = {UP: range(3), DOWN: range(3, 6), TURN: range(6), EXACT: range(0)}

Visit = tuple[str, int, int]  # what to do, on which level, in which cycle


def walk(cycle: Cycle, level: int, coarsest: int, number: int = 0) -> Iterator[Visit]:
    """The steps of cycle `number`, beginning on `level`."""
    if level == coarsest:
        yield EXACT, level, number
        return
    yield DOWN, level, number
    # An exactly solved level is visited once: a second visit would change nothing.
    for visit in VISITS[cycle] if level + 1 < coarsest else ("V",):
        yield from walk(visit, level + 1, coarsest, number)
    yield UP, level, number


def journey(cycle: Cycle, coarsest: int, cycles: int) -> list[Visit]:
    """The steps of several cycles in a row, with turns."""
    visits: list[Visit] = []
    for number in range(cycles):
        for visit in walk(cycle, 0, coarsest, number):
            last = visits[-1] if visits else None
            if last is not None and (last[:2], visit[0]) == ((UP, visit[1]), DOWN):
                visits[-1] = TURN, *last[1:]
            else:
                visits.append(visit)
    return visits


class Cycling:
    """Cycles over one hierarchy, with the scratch memory that they need.

    A cycle is a list of calls of one kernel, which runs steps.  Large levels are visited in calls of their own, their
    segments shared out among the team; what there is to do on small levels, and between the bands of large ones, is one
    call by one thread as far as it follows each other.  A call stays well below 0.2 s, so that signals are heard
    between them.
    """

    def __init__(self, hierarchy: Hierarchy, cycle: Cycle, channels: int, team: Team) -> None:
        self.hierarchy = hierarchy
        self.channels = channels
        self.team = team
        self.names = [cycle]
        self._stronger = False
        # A segment's residuals in all channels, or two of interpolated values, and what whole vectors add.
        room = max(channels, 2) * (hierarchy.longest_segment + 3 * LANES)
        self.scratch = [aligned_zeros(room) for _ in range(team.threads)]
        self.scratch64 = np.zeros(len(hierarchy.coarsest.band), np.float64)
        self.n_large = sum(team.shares(n * channels) for n in hierarchy.unknowns[:-1])
        self._plans: dict[tuple[Cycle, int], list[list[NDArray[np.int64]]]] = {}

    def strengthen(self) -> None:
        """Begin the next run with the next stronger cycle, if there is one, however often this is said before it."""
        self._stronger = True

    def run(self, x: Float32, b: Float32, cycles: int = 1) -> Iterator[float]:
        """Some cycles for A x = b, in place, as far as the result is gone through.

        Tells of each, as it ends, a bound of the largest change of any black pixel.
        """
        h, coarsest = self.hierarchy, self.hierarchy.coarsest
        fields = x, b, h.weight, h.diagonal, h.share, h.edge_e, h.edge_s, coarsest.band, coarsest.cells
        changes = np.zeros((self.team.threads, cycles + 1, 3), np.int32)
        if self._stronger and self.names[-1] in STRONGER:
            self.names.append(STRONGER[self.names[-1]])
        self._stronger = False
        plan = (self.names[-1], cycles)
        if plan not in self._plans:
            self._plans[plan] = self._plan(*plan)
        calls = self._plans[plan]
        done = 0
        for k, call in enumerate(calls):
            parts = [
                (mine, *fields, scratch, self.scratch64, h.runs, h.segments, h.table, steps, self.channels)
                for mine, scratch, steps in zip(changes, self.scratch, call, strict=False)
            ]
            self.team.run(kernels.run_steps, parts)
            following = int(calls[k + 1][0][0, kernels.CYCLE]) if k + 1 < len(calls) else cycles
            if following > done:
                largest = changes[:, done:following].max(0).view(np.float32)
                yield from largest.sum(1, dtype=np.float64).tolist()
            done = following

    def _plan(self, cycle: Cycle, cycles: int) -> list[list[NDArray[np.int64]]]:
        """The calls of some cycles: of each, the steps for every thread that takes part."""
        coarsest = self.hierarchy.n_levels - 1
        if self.n_large == 0:
            return [[_by_one_thread(cycle, coarsest, cycles)]]
        bands = [_bands(self.hierarchy, level, self.channels, self.team) for level in range(self.n_large)]
        calls: list[list[NDArray[np.int64]]] = []
        alone: list[list[int]] = []  # steps for a single thread
        for kind, level, number in journey(cycle, coarsest, cycles):
            if level >= self.n_large:
                alone.append(_step(kind, level, number, _ranges(OPERATIONS[kind])))
                continue
            for phase in _phases(OPERATIONS[kind], bands[level], self.channels):
                steps = [_step(kind, level, number, ranges) for ranges in phase.ranges]
                if not phase.shared:
                    alone += steps
                    continue
                calls += [[np.array(alone, np.int64)]] if alone else []
                alone = []
                threads = self.team.threads
                calls += [
                    [np.array([one], np.int64) for one in steps[k : k + threads]]
                    for k in range(0, len(steps), threads)
                ]
        return [*calls, [np.array(alone, np.int64)]] if alone else calls


@cache
def _by_one_thread(cycle: Cycle, coarsest: int, cycles: int) -> NDArray[np.int64]:
    """The steps of some cycles that one thread runs in one call: the same for every hierarchy of so many levels."""
    steps = [
        _step(kind, level, number, _ranges(OPERATIONS[kind]))
        for kind, level, number in journey(cycle, coarsest, cycles)
    ]
    return np.array(steps, np.int64)


def _step(visit: str, level: int, number: int, ranges: list[int]) -> list[int]:
    """A step for `kernels.cycle.run_steps`.  Going down, a coarse level begins at zero."""
    kind = {DOWN: kernels.SWEEP, UP: kernels.SWEEP, TURN: kernels.TURN, EXACT: kernels.COARSEST}[visit]
    return [kernels.SWEEP_FROM_ZERO if visit == DOWN and level > 0 else kind, level, number, *ranges]


def _ranges(operations: Iterable[int], band: Band = (0, kernels.WHOLE)) -> list[int]:
    """The bounds of a sweep that does these operations on one range of segments."""
    bounds = [0] * (kernels.COLUMNS - kernels.PROLONG)
    for operation in operations:
        bounds[2 * operation : 2 * operation + 2] = band
    return bounds


class _Phase(NamedTuple):
    """Ranges for sweeps of which none touches what another one changes, and whether it pays to hand them out."""

    ranges: list[list[int]]
    shared: bool


class _Shrinking(NamedTuple):
    """A band of segments, and what is left of it after each operation; see `_phases`."""

    ranges: list[Band]
    places: NDArray[np.int64]  # of all segments before each one, from the level's first on
    first: int


def _bands(hierarchy: Hierarchy, level: int, channels: int, team: Team) -> list[_Shrinking]:
    """A large level's bands.

    Each operation reads the neighbours of what it changes, as they were left by the one before it.  In a wave over a
    band it must therefore leave out what has neighbours where the one before it has not been.
    """
    table = hierarchy.table
    first, end = int(table[level, FIRST_SEGMENT]), int(table[level + 1, FIRST_SEGMENT])
    starts, ends = hierarchy.segments[first:end, 0], hierarchy.segments[first:end, 1]
    reach = int(table[level, STRIDE]) + 1
    places = np.concatenate([[0], np.cumsum(ends - starts)])

    def inner(low: int, high: int) -> Band:
        """Those of segments [low, high) whose neighbours lie in [low, high) too, or beyond the level."""
        a, b = low, high
        if low > first:
            a = first + int(np.searchsorted(starts, ends[low - first - 1] + reach))
        if high < end:
            b = first + int(np.searchsorted(ends, starts[high - first] - reach, side="right"))
        a = min(a, high)
        return a, max(a, b)

    shrinking = []
    for band in team.bands(ends - starts, first, channels * hierarchy.unknowns[level]):
        ranges = [band]
        while len(ranges) < N_OPERATIONS:
            low, high = ranges[-1]
            ranges.append(inner(low, high) if low < high else (low, high))
        shrinking.append(_Shrinking(ranges, places, first))
    return shrinking


def _phases(operations: range, bands: list[_Shrinking], channels: int) -> list[_Phase]:
    """The phases of a visit to a large level: a wave in each band, then operation by operation what waves left out."""
    wave = []
    left: list[list[list[int]]] = [[] for _ in operations]
    sizes = [0 for _ in operations]
    for band in bands:
        ranges = [0] * (kernels.COLUMNS - kernels.PROLONG)
        low, high = band.ranges[0]
        for k, operation in enumerate(operations):
            done = band.ranges[k]
            ranges[2 * operation : 2 * operation + 2] = done
            for a, b in ((low, done[0]), (done[1], high)):
                if a < b:
                    left[k].append(_ranges([operation], (a, b)))
                    sizes[k] += int(band.places[b - band.first] - band.places[a - band.first])
        wave.append(ranges)
    # What is left is a few rows, whose work seldom takes as long as it takes to hand it out.
    rest = [
        _Phase(ranges, shared=2 * channels * places >= WORTH_SHARING)
        for ranges, places in zip(left, sizes, strict=True)
        if ranges
    ]
    return [_Phase(wave, shared=True), *rest]
