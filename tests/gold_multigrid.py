"""Multigrid with dense matrices and plain loops: slow, float64, and short enough to be checked by reading.

The grids and operators are those that `solvers` promises.  A cell of a coarse grid stands for 2 x 2 cells of the
finer one and is active if any of them is.  Cells are joined to their neighbours by conductances, and to the known
values around them by one *leak* per direction; a cell's diagonal entry is the sum of its conductances and leaks.
Imports numpy only.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

Array = np.ndarray

DIRECTIONS = {"north": (-1, 0), "south": (1, 0), "west": (0, -1), "east": (0, 1)}
LEAST_RESISTANCE = 0.25  # of a leak: a known value never seems nearer than a quarter of a cell
OVERCORRECTION = 1.0375  # the interpolated correction is made this much larger,
BESIDE_KNOWN = 6 / 7  # but this much smaller in cells that leak
OVERRELAXATION = (
    1.7  # of the black cells after a correction, on the finest grid and where another sweep follows
)
SOLVED_DIRECTLY = 64  # unknowns; a grid with a side of 2 is solved directly too


@dataclass
class Grid:
    """One level: which cells are unknown, and how they are joined."""

    active: Array  # (H, W) bool
    east: Array  # (H, W), conductance to the neighbour in the east, 0 where there is none
    south: Array  # (H, W), to the neighbour in the south
    leak: dict[str, Array]  # (H, W) per direction, conductance to the known value there

    @classmethod
    def empty(cls, height: int, width: int) -> "Grid":
        """No active cell, and nothing joined to anything."""

        def zeros() -> Array:
            return np.zeros((height, width))

        return cls(zeros() > 0, zeros(), zeros(), {direction: zeros() for direction in DIRECTIONS})

    @property
    def cells(self) -> list[tuple[int, int]]:
        """The active cells in reading order: the order of the unknowns."""
        return [(int(row), int(col)) for row, col in np.argwhere(self.active)]

    def diagonal(self) -> Array:
        """(H, W): the sum of all that a cell is joined by."""
        total = self.east + self.south + sum(self.leak.values())
        total[:, 1:] += self.east[:, :-1]
        total[1:] += self.south[:-1]
        return total

    def matrix(self) -> Array:
        """The operator, (n, n)."""
        number = {cell: i for i, cell in enumerate(self.cells)}
        a = np.diag(self.diagonal()[self.active])
        for (row, col), i in number.items():
            for conductance, beside in ((self.east, (row, col + 1)), (self.south, (row + 1, col))):
                if conductance[row, col]:
                    j = number[beside]
                    a[i, j] = a[j, i] = -conductance[row, col]
        return a


def finest(region: Array) -> Grid:
    """Eq. (7): every neighbour inside the image counts 1, whether known or not; beyond the edge there is none."""
    height, width = region.shape
    grid = Grid.empty(height, width)
    grid.active[:] = region
    for row, col in grid.cells:
        for direction, (down, right) in DIRECTIONS.items():
            r, c = row + down, col + right
            if not (0 <= r < height and 0 <= c < width):
                continue
            if not region[r, c]:
                grid.leak[direction][row, col] = 1
            elif direction == "east":
                grid.east[row, col] = 1
            elif direction == "south":
                grid.south[row, col] = 1
    return grid


def children(row: int, col: int, shape: tuple[int, int]) -> Iterator[tuple[int, int]]:
    """The cells of the finer grid that a coarse cell stands for; at an odd edge there are fewer than four."""
    for r in (2 * row, 2 * row + 1):
        for c in (2 * col, 2 * col + 1):
            if r < shape[0] and c < shape[1]:
                yield r, c


def leak_seen_from(conductance: float, quarters: int) -> float:
    """A leak as the parent sees it, whose centre is a quarter of a cell further from the known value, or nearer."""
    return 1 / max(1 / conductance + quarters / 4, LEAST_RESISTANCE)


def coarser(fine: Grid) -> Grid:
    """2 x 2 aggregation."""
    height, width = ((side + 1) // 2 for side in fine.active.shape)
    grid = Grid.empty(height, width)
    for row in range(height):
        for col in range(width):
            for r, c in children(row, col, fine.active.shape):
                grid.active[row, col] |= fine.active[r, c]
                # An edge between two aggregates becomes longer by one: the resistances add up.
                if c == 2 * col + 1 and fine.east[r, c]:
                    grid.east[row, col] += 1 / (1 + 1 / fine.east[r, c])
                if r == 2 * row + 1 and fine.south[r, c]:
                    grid.south[row, col] += 1 / (1 + 1 / fine.south[r, c])
                for direction, (down, right) in DIRECTIONS.items():
                    if fine.leak[direction][r, c]:
                        # The child in the direction of the known value is nearer to it than the parent's centre.
                        step = down or right
                        half = (r if down else c) % 2
                        outer = half == (1 if step > 0 else 0)
                        leak = leak_seen_from(fine.leak[direction][r, c], +1 if outer else -1)
                        grid.leak[direction][row, col] += leak
    return grid


def restriction(fine: Grid, coarse: Grid) -> Array:
    """(n_coarse, n_fine): the sum over the children."""
    fine_number = {cell: i for i, cell in enumerate(fine.cells)}
    r = np.zeros((len(coarse.cells), len(fine_number)))
    for i, cell in enumerate(coarse.cells):
        for child in children(*cell, fine.active.shape):
            if child in fine_number:
                r[i, fine_number[child]] = 1
    return r


def prolongation(fine: Grid, coarse: Grid) -> Array:
    """(n_fine, n_coarse): bilinear between cell centres; an inactive cell counts as zero, the edge is repeated.

    Times `OVERCORRECTION`, and `BESIDE_KNOWN`.
    """
    leaky = sum(fine.leak.values()) > 0
    coarse_number = {cell: i for i, cell in enumerate(coarse.cells)}
    p = np.zeros((len(fine.cells), len(coarse_number)))
    for i, (row, col) in enumerate(fine.cells):
        rows = ((row // 2, 3 / 4), (row // 2 + (1 if row % 2 else -1), 1 / 4))
        cols = ((col // 2, 3 / 4), (col // 2 + (1 if col % 2 else -1), 1 / 4))
        for r, row_weight in rows:
            for c, col_weight in cols:
                inside = (
                    min(max(r, 0), coarse.active.shape[0] - 1),
                    min(max(c, 0), coarse.active.shape[1] - 1),
                )
                if inside in coarse_number:
                    p[i, coarse_number[inside]] += OVERCORRECTION * row_weight * col_weight
        p[i] *= BESIDE_KNOWN if leaky[row, col] else 1
    return p


def grids(region: Array) -> list[Grid]:
    """All levels, finest first, down to one that is solved directly."""
    levels = [finest(region)]
    while levels[-1].active.sum() > SOLVED_DIRECTLY and min(levels[-1].active.shape) > 2:
        levels.append(coarser(levels[-1]))
    return levels


class Multigrid:
    """V-, F- and W-cycles with one red-black Gauss-Seidel sweep before and one after."""

    def __init__(self, region: Array) -> None:
        levels = grids(region)
        self.matrices = [grid.matrix() for grid in levels]
        self.red = [np.array([(row + col) % 2 == 0 for row, col in grid.cells], bool) for grid in levels]
        pairs = list(pairwise(levels))
        self.down = [restriction(*pair) for pair in pairs]
        self.up = [prolongation(*pair) for pair in pairs]

    def sweep(self, level: int, u: Array, b: Array, omega: float = 1.0) -> None:
        a = self.matrices[level]
        for colour, factor in ((self.red[level], 1.0), (~self.red[level], omega)):
            u[colour] += factor * (b - a @ u)[colour] / np.diag(a)[colour]

    def cycle(self, kind: str, u: Array, b: Array, level: int = 0, *, last: bool = True) -> None:
        """One cycle, in place; unless it is the `last` one, another one follows at once."""
        if level == len(self.matrices) - 1:
            u[:] = np.linalg.solve(self.matrices[level], b)
            return
        self.sweep(level, u, b)
        coarse_b = self.down[level] @ (b - self.matrices[level] @ u)
        coarse_u = np.zeros_like(coarse_b)
        visits = {"V": "V", "F": "FV", "W": "WW"}[kind]
        visits = visits if level + 2 < len(self.matrices) else visits[:1]
        for k, visit in enumerate(visits):
            self.cycle(visit, coarse_u, coarse_b, level + 1, last=k == len(visits) - 1)
        u += self.up[level] @ coarse_u
        self.sweep(level, u, b, 1.0 if last and level > 0 else OVERRELAXATION)
