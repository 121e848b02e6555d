"""V-, F- and W-cycles, each written as the list of its steps.

A step names what to do and on which level:

    DOWN l        smooth level l, hand the residual's right-hand side to level l + 1, whose unknowns become zero
    UP l          add the interpolated solution of level l + 1, smooth level l
    COARSEST l    solve the coarsest level l exactly

"Smooth" is one red-black Gauss-Seidel sweep.  The recursion is unrolled here, in Python, once per solve; a compiled
kernel runs the list.
"""

from collections.abc import Iterator
from typing import Literal, get_args

import numpy as np
from numpy.typing import NDArray

from solvers.hierarchy import Hierarchy
from solvers.kernels.cycle import COARSEST, DOWN, UP, run_steps
from solvers.layout import LANES, STRIDE, Float32, aligned_zeros

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


def steps_of(cycle: Cycle, n_levels: int) -> NDArray[np.int64]:
    """The steps of one cycle over `n_levels` levels, (n, 2) int64: step, level."""
    return np.array(list(walk(cycle, 0, n_levels - 1)), np.int64)


class Cycling:
    """Cycles over one hierarchy, with the scratch memory that they need."""

    def __init__(self, hierarchy: Hierarchy, cycle: Cycle, channels: int) -> None:
        self.hierarchy = hierarchy
        self.channels = channels
        self.names = [cycle]
        self.steps = steps_of(cycle, hierarchy.n_levels)
        # A segment and a row of coarse cells with two more on each side, and the same again.
        room = hierarchy.longest_segment + int(hierarchy.table[0, STRIDE]) + 2 * LANES
        self.scratch = aligned_zeros(2 * room)
        self.scratch64 = np.zeros(len(hierarchy.coarsest.band), np.float64)

    def strengthen(self) -> None:
        """Go on with the next stronger cycle, if there is one."""
        if self.names[-1] in STRONGER:
            self.names.append(STRONGER[self.names[-1]])
            self.steps = steps_of(self.names[-1], self.hierarchy.n_levels)

    def run(self, x: Float32, b: Float32) -> float:
        """One cycle for A x = b, in place; returns a bound of the largest change of any black pixel."""
        h, coarsest = self.hierarchy, self.hierarchy.coarsest
        bits = run_steps(
            x, b, h.weight, h.diagonal, h.edge_e, h.edge_s, coarsest.band, coarsest.cells,
            self.scratch, self.scratch64, h.runs, h.segments, h.table, self.steps, self.channels,
        )  # fmt: skip
        return float(np.array(bits, np.int32).view(np.float32).sum(dtype=np.float64))
