"""The grids of a region, from the pixels down to a grid that is solved directly.

Cell-centred 2 x 2 aggregation, a 5-point operator on every level.  A level has conductances between neighbouring cells,
and one *leak* per direction to the known values beside it.  A leak keeps its direction when cells merge, and with it
the known value's distance: that is what makes one coarse operator work on every region, thin and ragged ones included.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from solvers import kernels
from solvers.layout import HEIGHT, LANES, OFFSET, STRIDE, WIDTH, field, layout_table

EXACT_UNKNOWNS = 20  # a level with at most so many unknowns is solved directly,
EXACT_SIDE = 2  # and so is a level with a side this short: its matrix has a narrow band

RUN_GAP = LANES  # empty indices that are cheaper to sweep than to begin a new run

Bool2D = NDArray[np.bool_]
Float32 = NDArray[np.float32]


@dataclass(frozen=True)
class Conductances:
    """One level's operator on a plain grid, padded to even sides.

    Attributes
    ----------
    edge_e, edge_s : (H, W) float32
        Between a cell and its east, its south neighbour; 0 where either is inactive.
    leak : (4, H, W) float32
        From a cell to the known value in the north, south, west, east; 0 where there is none.
    """

    edge_e: Float32
    edge_s: Float32
    leak: Float32

    @classmethod
    def zeros(cls, height: int, width: int) -> "Conductances":
        shape = (height + height % 2, width + width % 2)
        return cls(np.zeros(shape, np.float32), np.zeros(shape, np.float32), np.zeros((4, *shape), np.float32))

    def diagonal(self) -> Float32:
        """The sum of each cell's conductances, 0 for an inactive cell."""
        total = self.leak.sum(0) + self.edge_e + self.edge_s
        total[:, 1:] += self.edge_e[:, :-1]
        total[1:] += self.edge_s[:-1]
        return total


@dataclass(frozen=True)
class Coarsest:
    """The coarsest level's matrix, factored: see `kernels.solve_coarsest`."""

    band: NDArray[np.float64]
    cell_row: NDArray[np.int64]
    cell_index: NDArray[np.int64]


@dataclass(frozen=True)
class Hierarchy:
    """All levels of a region, in the layout of `solvers.layout`; made by `build_hierarchy`.

    Attributes
    ----------
    region : (H, W) bool
        True = unknown.
    table : (n_levels + 1, 6) int64
        The layout.
    runs, run_start : (n, 2) int32, (n_rows + 1,) int64
        The stretches of each row that hold unknowns.
    weight, diagonal : float32
        Fields of one channel: the operator's diagonal, and its inverse (0 outside the region).
    edge_e, edge_s : float32
        Fields of one channel, without the finest level.
    unknowns : tuple of int
        Number of unknowns, per level.
    coarsest : Coarsest
    """

    region: Bool2D
    table: NDArray[np.int64]
    runs: NDArray[np.int32]
    run_start: NDArray[np.int64]
    weight: Float32
    diagonal: Float32
    edge_e: Float32
    edge_s: Float32
    unknowns: tuple[int, ...]
    coarsest: Coarsest

    @property
    def n_levels(self) -> int:
        return len(self.unknowns)

    @property
    def finest_size(self) -> int:
        """Length of the finest level of a one-channel field."""
        return int(self.table[1, OFFSET])

    def shape(self, level: int) -> tuple[int, int]:
        """Height and width of a level's grid."""
        return int(self.table[level, HEIGHT]), int(self.table[level, WIDTH])

    def plain(self, values: Float32, level: int, *, skipped: int = 0) -> Float32:
        """A level of a one-channel field as a (height, width) array: for looking at, and for tests."""
        height, width, half, stride, offset, _ = (int(n) for n in self.table[level])
        rows = values[offset - skipped :][: (height + 2) * 2 * stride].reshape(-1, 2, stride)[1 : height + 1, :, :half]
        grid = np.zeros((height, 2 * half), np.float32)
        for colour in (0, 1):
            grid[0::2, colour::2] = rows[0::2, colour]
            grid[1::2, 1 - colour :: 2] = rows[1::2, colour]
        return grid[:, :width]

    def operator(self, level: int) -> tuple[Float32, Float32, Float32]:
        """`edge_e`, `edge_s`, `diagonal` of a level as (height, width) arrays."""
        diagonal = self.plain(self.diagonal, level)
        if level == 0:
            edge_e, edge_s = np.zeros_like(diagonal), np.zeros_like(diagonal)
            edge_e[:, :-1] = self.region[:, :-1] & self.region[:, 1:]
            edge_s[:-1] = self.region[:-1] & self.region[1:]
            return edge_e, edge_s, diagonal
        skipped = self.finest_size
        return (
            self.plain(self.edge_e, level, skipped=skipped),
            self.plain(self.edge_s, level, skipped=skipped),
            diagonal,
        )

    def __str__(self) -> str:
        lines = ["level   unknowns          grid   filled"]
        for level, unknowns in enumerate(self.unknowns):
            height, width = self.shape(level)
            lines.append(f"{level:5d} {unknowns:10,d} {f'{width} x {height}':>13s} {unknowns / (height * width):7.0%}")
        total = sum(self.unknowns) / max(1, self.unknowns[0])
        lines.append(f"{sum(self.unknowns):,d} unknowns in all, {total:.2f} times the finest level")
        return "\n".join(lines)


def describe(region: Bool2D) -> str:
    """The hierarchy of a region as a table: unknowns, grid and filled share of each level."""
    return str(build_hierarchy(region))


def build_hierarchy(region: Bool2D) -> Hierarchy:
    """Levels of a region, finest first.

    Parameters
    ----------
    region : (H, W) bool
        True = unknown.  At least one pixel must be False: without a known value the operator is singular.
    """
    region = np.ascontiguousarray(region, dtype=np.bool_)
    shapes = [(int(region.shape[0]), int(region.shape[1]))]
    runs, run_start = [], []

    start = np.zeros(shapes[0][0] + 1, np.int64)
    found = np.zeros((kernels.find_runs(np.zeros((0, 2), np.int32), start, region, RUN_GAP), 2), np.int32)
    kernels.find_runs(found, start, region, RUN_GAP)
    runs.append(found)
    run_start.append(start)
    unknowns = [int(np.count_nonzero(region))]

    plain: list[Conductances] = []  # of the coarse levels
    fine = Conductances.zeros(*shapes[0])
    kernels.conductances_of_region(fine.edge_e, fine.edge_s, fine.leak, region)
    while unknowns[-1] > EXACT_UNKNOWNS and min(shapes[-1]) > EXACT_SIDE:
        height, width = (shapes[-1][0] + 1) // 2, (shapes[-1][1] + 1) // 2
        found, start = np.zeros_like(runs[-1]), np.zeros(height + 1, np.int64)
        count = kernels.coarsen_runs(found, start, runs[-1], run_start[-1], shapes[-1][0], RUN_GAP)
        coarse = Conductances.zeros(height, width)
        kernels.coarsen(
            coarse.edge_e, coarse.edge_s, coarse.leak, fine.edge_e, fine.edge_s, fine.leak,
            found[:count], start, height, width,
        )  # fmt: skip
        shapes.append((height, width))
        runs.append(found[:count])
        run_start.append(start)
        plain.append(coarse)
        unknowns.append(int(np.count_nonzero(coarse.diagonal())))
        fine = coarse

    table = layout_table(shapes)
    coarsest = _factor(fine, shapes[-1], int(table[-2, STRIDE]))
    bases = np.cumsum([0] + [len(r) for r in runs[:-1]])
    all_starts = np.concatenate([s[:-1] + base for s, base in zip(run_start, bases, strict=True)] + [[sum(map(len, runs))]])
    all_runs = np.concatenate(runs)
    weight, diagonal = field(table, 1), field(table, 1)
    split_e = np.zeros(weight.size - int(table[1, OFFSET]), np.float32)
    split_s = np.zeros_like(split_e)
    kernels.split_region(weight, diagonal, region, all_runs, all_starts, table)
    for level, coarse in enumerate(plain, start=1):
        kernels.split_conductances(
            weight, diagonal, split_e, split_s, coarse.edge_e, coarse.edge_s, coarse.leak,
            all_runs, all_starts, table, level,
        )  # fmt: skip
    return Hierarchy(
        region, table, all_runs, all_starts, weight, diagonal, split_e, split_s, tuple(unknowns), coarsest
    )


def _factor(level: Conductances, shape: tuple[int, int], stride: int) -> Coarsest:
    """Cholesky factor of a level's matrix, cells numbered along the longer side to keep the band narrow."""
    diagonal = level.diagonal().astype(np.float64)
    if shape[1] > shape[0]:
        col, row = np.nonzero(diagonal.T)
    else:
        row, col = np.nonzero(diagonal)
    number = np.full(diagonal.shape, -1, np.int64)
    number[row, col] = np.arange(row.size)
    entries = []
    for edge, (down, right) in ((level.edge_e, (0, 1)), (level.edge_s, (1, 0))):
        r, c = np.nonzero(edge)
        p, q = number[r, c], number[r + down, c + right]
        entries.append((np.maximum(p, q), np.abs(p - q), edge[r, c]))
    bandwidth = max((int(distance.max(initial=0)) for _, distance, _ in entries), default=0)
    band = np.zeros((row.size, bandwidth + 1))
    band[:, 0] = diagonal[row, col]
    for i, distance, w in entries:
        band[i, distance] = -w
    kernels.factor_band(band)
    colour = (row + col) % 2
    return Coarsest(band, row.astype(np.int64), (colour * stride + col // 2).astype(np.int64))
