"""V-, F- and W-cycles, each written as the list of its steps.

A step names what to do and on which level:

    DOWN l        smooth level l, hand the residual's right-hand side to level l + 1, whose unknowns become zero
    UP l          add the interpolated solution of level l + 1, smooth level l
    COARSEST l    solve the coarsest level l exactly

"Smooth" is one red-black Gauss-Seidel sweep.  The recursion is unrolled here, in Python, once per solve; a compiled
kernel runs the list.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np
from numpy.typing import NDArray

from solvers.hierarchy import Hierarchy
from solvers.kernels.cycle import COARSEST, DOWN, UP, run_steps
from solvers.layout import FIRST_SEGMENT, LANES, STRIDE, Float32, aligned_zeros
from solvers.team import LONG_CALL, WORTH_SHARING, Band, Team

Cycle = Literal["V", "F", "W"]
CYCLES: tuple[Cycle, ...] = get_args(Cycle)

# How a cycle visits the level below: once, or twice in a row.
VISITS: dict[Cycle, tuple[Cycle, ...]] = {"V": ("V",), "F": ("F", "V"), "W": ("W", "W")}

# What to go on with where a cycle contracts badly.
STRONGER: dict[Cycle, Cycle] = {"V": "F", "F": "W"}


def walk(cycle: Cycle, level: int, coarsest: int) -> Iterator[tuple[int, int]]:
    """The steps of one cycle that begins on `level`."""
    if level == coarsest:
        yield COARSEST, level
        return
    yield DOWN, level
    # An exactly solved level is visited once: a second visit would change nothing.
    for visit in VISITS[cycle] if level + 1 < coarsest else ("V",):
        yield from walk(visit, level + 1, coarsest)
    yield UP, level


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
        # A segment and a row of coarse cells with one more on each side.
        room = hierarchy.longest_segment + int(hierarchy.table[0, STRIDE]) + 2 * LANES
        self.scratch = [aligned_zeros(room) for _ in range(team.threads)]
        self.scratch64 = np.zeros(len(hierarchy.coarsest.band), np.float64)
        large = WORTH_SHARING if team.threads > 1 else LONG_CALL
        self.n_large = sum(n * channels >= large for n in hierarchy.unknowns[:-1])
        self.calls = self._plan(cycle)

    def strengthen(self) -> None:
        """Go on with the next stronger cycle, if there is one."""
        if self.names[-1] in STRONGER:
            self.names.append(STRONGER[self.names[-1]])
            self.calls = self._plan(self.names[-1])

    def run(self, x: Float32, b: Float32) -> float:
        """One cycle for A x = b, in place; returns a bound of the largest change of any black pixel."""
        h, coarsest = self.hierarchy, self.hierarchy.coarsest
        fields = x, b, h.weight, h.diagonal, h.edge_e, h.edge_s, coarsest.band, coarsest.cells
        changes = np.zeros(3, np.int32)
        for call in self.calls:
            parts = [
                (*fields, scratch, self.scratch64, h.runs, h.segments, h.table, steps, self.channels)
                for scratch, steps in zip(self.scratch, call, strict=False)
            ]
            for bits in self.team.run(run_steps, parts):
                changes = np.maximum(changes, np.array(bits, np.int32))
        return float(changes.view(np.float32).sum(dtype=np.float64))

    def _plan(self, cycle: Cycle) -> list[list[NDArray[np.int64]]]:
        """The calls of a cycle: of each, the steps for every thread that takes part."""
        table = self.hierarchy.table
        first = table[:-1, FIRST_SEGMENT].tolist()
        end = table[1:, FIRST_SEGMENT].tolist()
        phases = [_phases(self.hierarchy, level, self.channels, self.team) for level in range(self.n_large)]
        calls: list[list[NDArray[np.int64]]] = []
        alone: list[list[int]] = []  # steps for a single thread
        for step, level in walk(cycle, 0, self.hierarchy.n_levels - 1):
            if level >= self.n_large:
                alone.append(_whole(step, level, first[level], end[level]))
                continue
            for phase in phases[level][step]:
                if phase.shared:
                    calls += [[np.array(alone, np.int64)]] if alone else []
                    alone = []
                    calls += [
                        [np.array([one], np.int64) for one in phase.steps[k : k + self.team.threads]]
                        for k in range(0, len(phase.steps), self.team.threads)
                    ]
                else:
                    alone += phase.steps
        return [*calls, [np.array(alone, np.int64)]] if alone else calls


def _whole(step: int, level: int, first: int, end: int) -> list[int]:
    """A step on a whole level, for `kernels.cycle.run_steps`."""
    up, down = step == UP, step == DOWN
    return [step, level, first, end if up else first, first, end, first, end, first, end if down else first]


@dataclass(frozen=True)
class _Phase:
    """Steps of which none touches what another one changes, and whether it pays to hand them out."""

    steps: list[list[int]]
    shared: bool


def _phases(hierarchy: Hierarchy, level: int, channels: int, team: Team) -> dict[int, list[_Phase]]:
    """What a step down and a step up are on a level that is shared out, one phase after the other.

    Within a phase no step touches what another one changes.  The wave of a band leaves out what borders on another
    band: the black cells there wait until all red ones are done, the residuals until all black ones are; and
    interpolated values there must stand before any red cell reads them.
    """
    table = hierarchy.table
    first, end = int(table[level, FIRST_SEGMENT]), int(table[level + 1, FIRST_SEGMENT])
    starts, ends = hierarchy.segments[first:end, 0], hierarchy.segments[first:end, 1]
    reach = int(table[level, STRIDE]) + 1

    def inner(low: int, high: int) -> Band:
        """Those of segments [low, high) whose neighbours lie in [low, high) too, or beyond the level."""
        a = low if low == first else first + int(np.searchsorted(starts, ends[low - first - 1] + reach))
        b = (
            high
            if high == end
            else first + int(np.searchsorted(ends, starts[high - first] - reach, side="right"))
        )
        a = min(a, high)
        return a, max(a, b)

    none = (first, first)
    wave_down, wave_up, seam, black, residual = [], [], [], [], []
    bands = team.bands(ends - starts, first)
    for low, high in bands:
        a, b = inner(low, high)
        c, d = inner(a, b) if len(bands) > 1 else (low, high)
        wave_down.append((none, (low, high), (a, b), (c, d)))
        wave_up.append(((a, b), (low, high), (a, b), none))
        seam += [((low, a), none, none, none), ((b, high), none, none, none)]
        black += [(none, none, (low, a), none), (none, none, (b, high), none)]
        residual += [(none, none, none, (low, c)), (none, none, none, (d, high))]

    def between(step: int, ranges: list[tuple[Band, Band, Band, Band]]) -> _Phase:
        """What is left between bands: a few rows, whose work seldom takes as long as it takes to hand it out."""
        places = sum(int((ends - starts)[a - first : b - first].sum()) for r in ranges for a, b in r)
        return _Phase(steps(step, ranges), shared=2 * channels * places >= WORTH_SHARING)

    def steps(step: int, ranges: list[tuple[Band, Band, Band, Band]]) -> list[list[int]]:
        work = [r for r in ranges if any(a < b for a, b in r)]
        return [[step, level, *(n for band in r for n in band)] for r in work]

    return {
        DOWN: [_Phase(steps(DOWN, wave_down), shared=True), between(DOWN, black), between(DOWN, residual)],
        UP: [between(UP, seam), _Phase(steps(UP, wave_up), shared=True), between(UP, black)],
    }
