"""The grids of a region, from the pixels down to a grid that is solved directly.

Cell-centred 2 x 2 aggregation, a 5-point operator on every level.  A level has conductances between neighbouring cells,
and one *leak* per direction to the known values beside it.  A leak keeps its direction when cells merge, and with it
the known value's distance: that is what makes one coarse operator work on every region, thin and ragged ones included.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from solvers.kernels import setup
from solvers.layout import (
    FIRST_RUN,
    FIRST_SEGMENT,
    HEIGHT,
    LANES,
    OFFSET,
    STRIDE,
    WIDTH,
    Float32,
    Table,
    aligned_zeros,
    field_size,
    layout_table,
)
from solvers.memory import Arena
from solvers.team import Team

EXACT_UNKNOWNS = 64  # a level with at most so many unknowns is solved directly,
EXACT_SIDE = 2  # and so is a level with a side this short: its matrix has a narrow band

# Runs with fewer empty places between them are joined: sweeping those is cheaper than beginning a new run, and runs
# stay apart when they are widened to whole vectors.
RUN_GAP = 2 * LANES

SEGMENT_GAP = 4 * LANES  # the same across the ends of rows
LONGEST_SEGMENT = (
    1024  # places, unless a single run is longer: a stretch of scratch stays in the first-level cache
)


class Coarsest(NamedTuple):
    """The coarsest level's matrix, factored: see `kernels.cycle.solve_coarsest`.

    Attributes
    ----------
    band : (n, bandwidth + 1) float64
    cells : (n,) int64
    softness : float
        The largest value of A^-1 1 there.
    """

    band: NDArray[np.float64]
    cells: NDArray[np.int64]
    softness: float


class Hierarchy(NamedTuple):
    """All levels of a region, in the layout of `solvers.layout`; made by `build_hierarchy`.

    Attributes
    ----------
    region : (H, W) bool
        True = unknown.
    table : (n_levels + 1, 9) int64
        The layout.
    runs, segments : (n, 3) int32, (n, 4) int64
        The places to visit, of all levels.
    weight, diagonal : float32
        Fields of one channel: the operator's diagonal, and its inverse (0 outside the region).
    share : uint8
        Field of one channel: what a black cell takes of an interpolated correction, in sevenths.
    edge_e, edge_s : float32
        Fields of one channel without the finest level: conductances to the east and south neighbour.
    unknowns : tuple of int
        Number of unknowns, per level.
    coarsest : Coarsest
    """

    region: NDArray[np.bool_]
    table: Table
    runs: NDArray[np.int32]
    segments: NDArray[np.int64]
    weight: Float32
    diagonal: Float32
    share: NDArray[np.uint8]
    edge_e: Float32
    edge_s: Float32
    unknowns: tuple[int, ...]
    coarsest: Coarsest

    @property
    def n_levels(self) -> int:
        """Number of levels, the finest included."""
        return len(self.unknowns)

    @property
    def finest_size(self) -> int:
        """Length of the finest level of a one-channel field."""
        return int(self.table[1, OFFSET])

    @property
    def longest_segment(self) -> int:
        """In places."""
        return int((self.segments[:, 1] - self.segments[:, 0]).max(initial=0))

    @property
    def finest_runs(self) -> NDArray[np.int32]:
        """Runs of the finest level."""
        return self.runs[: self.table[1, FIRST_RUN]]

    @property
    def finest_segments(self) -> NDArray[np.int64]:
        """Segments of the finest level."""
        return self.segments[: self.table[1, FIRST_SEGMENT]]

    def shape(self, level: int) -> tuple[int, int]:
        """Height and width of a level's grid."""
        return int(self.table[level, HEIGHT]), int(self.table[level, WIDTH])

    def operator(self, level: int) -> tuple[Float32, Float32, Float32]:
        """`edge_e`, `edge_s`, `diagonal` of a level as (height, width) arrays: for looking at, and for tests."""
        diagonal = plain_level(self.diagonal, self.table, level)
        if level == 0:
            edge_e, edge_s = np.zeros_like(diagonal), np.zeros_like(diagonal)
            edge_e[:, :-1] = self.region[:, :-1] & self.region[:, 1:]
            edge_s[:-1] = self.region[:-1] & self.region[1:]
            return edge_e, edge_s, diagonal
        skipped = self.finest_size
        return (
            plain_level(self.edge_e, self.table, level, skipped),
            plain_level(self.edge_s, self.table, level, skipped),
            diagonal,
        )

    def __str__(self) -> str:
        lines = ["level   unknowns          grid   filled"]
        for level, unknowns in enumerate(self.unknowns):
            height, width = self.shape(level)
            lines.append(
                f"{level:5d} {unknowns:10,d} {f'{width} x {height}':>13s} {unknowns / (height * width):7.0%}"
            )
        total = sum(self.unknowns) / max(1, self.unknowns[0])
        lines.append(f"{sum(self.unknowns):,d} unknowns in all, {total:.2f} times the finest level")
        return "\n".join(lines)


def describe(region: NDArray[np.bool_]) -> str:
    """The hierarchy of a region as a table: unknowns, grid and filled share of each level."""
    return str(build_hierarchy(region))


def build_hierarchy(
    region: NDArray[np.bool_],
    arena: Arena | None = None,
    team: Team | None = None,
    *,
    screening: float = 0.0,
    n_unknowns: int | None = None,
) -> Hierarchy:
    """Levels of a region, finest first.

    Parameters
    ----------
    region : (H, W) bool
        True = unknown.  At least one pixel must be False unless `screening` is positive: without a known value the
        operator is singular.  None need be True.
    arena : Arena, optional
        Where the coefficients are to lie; the hierarchy then lives no longer than what the arena hands out.
    team : Team, optional
        Who does it; the hierarchy is the same for any number of threads.
    screening : float
        What is added to the finest diagonal; a coarse cell's diagonal holds it once per unknown pixel in the cell.
    n_unknowns : int, optional
        How many pixels are unknown, if they have been counted.
    """
    arena, team = arena or Arena(), team or Team(1, region.size)
    region = np.ascontiguousarray(region, dtype=np.bool_)
    table = layout_table(_shapes(*region.shape))
    runs, segments = _lay_out(_finest_runs(region, team), table)

    # Each operation writes at the places of its own runs or segments, and reads what the one before it left.
    size, stride = field_size(table, 1), int(table[0, STRIDE])
    coarse_size = size - int(table[1, OFFSET])
    as_bytes = -(-size // (4 * LANES)) * LANES
    weight, diagonal, edge_e, edge_s, words = arena.zeros_each(size, size, coarse_size, coarse_size, as_bytes)
    share = words.view(np.uint8)
    conductances = edge_e, edge_s, *arena.zeros_each(*[coarse_size] * 4)  # leaks are of no use later
    unknowns = np.zeros(len(table) - 1, np.int64)
    unknowns[0] = np.count_nonzero(region) if n_unknowns is None else n_unknowns
    parts = team.pieces(runs[: table[1, FIRST_RUN]], 1, int(unknowns[0]))
    team.run(setup.weigh_region, [(weight, diagonal, share, region, part, table) for part in parts])

    def coarsen(part: NDArray[np.int32], level: int) -> None:
        if level == 1:
            setup.coarsen_region(*conductances, aligned_zeros(6 * stride), weight, part, table)
        else:
            setup.coarsen(*conductances, aligned_zeros(stride), part, table, level - 1)

    level = 1
    while level < len(unknowns):
        cells = int(unknowns[level - 1])
        if cells <= EXACT_UNKNOWNS or not team.shares(cells):
            break
        fine = runs[table[level - 1, FIRST_RUN] : table[level, FIRST_RUN]]
        team.run(coarsen, [(part, level) for part in team.pieces(fine, 1, cells)])
        own = segments[table[level, FIRST_SEGMENT] : table[level + 1, FIRST_SEGMENT]]
        weighed = [
            (weight, diagonal, share, *conductances, part, table, level)
            for part in team.pieces(own, 0, cells)
        ]
        unknowns[level] = sum(int(n) for n in team.run(setup.weigh, weighed))
        level += 1
    scratch = aligned_zeros(6 * stride)
    fields = unknowns, weight, diagonal, share, *conductances, scratch, runs, segments, table
    n_levels = int(setup.build_levels(*fields, level, EXACT_UNKNOWNS))

    # The depth was known only now: coarser levels, laid out above, are left out.
    table = table[: n_levels + 1]
    if screening > 0:
        mass = arena.zeros(size)
        setup.screen(mass, weight, diagonal, scratch, runs, segments, table, np.float32(screening))
    return Hierarchy(
        region,
        table,
        runs[: table[-1, FIRST_RUN]],
        segments[: table[-1, FIRST_SEGMENT]],
        weight,
        diagonal,
        share,
        edge_e,
        edge_s,
        tuple(unknowns[:n_levels].tolist()),
        _factor(diagonal, edge_e, edge_s, table, int(unknowns[n_levels - 1])),
    )


def _shapes(height: int, width: int) -> list[tuple[int, int]]:
    """Of all levels that there may be, finest first."""
    shapes = [(height, width)]
    while min(shapes[-1]) > EXACT_SIDE:
        height, width = (height + 1) // 2, (width + 1) // 2
        shapes.append((height, width))
    return shapes


def _finest_runs(region: NDArray[np.bool_], team: Team) -> NDArray[np.int32]:
    """Runs of the finest level."""
    bands = team.rows(len(region), region.size)
    # Mostly one or two in a row of places; where there are more they are counted first.
    found = [np.empty((end - first, 3), np.int32) for first, end in bands]

    def find_runs(part: NDArray[np.int32], first: int, end: int) -> int:
        words = np.zeros(region.shape[1] // 16 + 1, np.int64)
        return int(setup.find_runs(part, words, words.view(np.uint8), region[first:end], RUN_GAP))

    counts = team.run(find_runs, [(part, *band) for part, band in zip(found, bands, strict=True)])
    for k, (part, (first, end)) in enumerate(zip(found, bands, strict=True)):
        if counts[k] > len(part):
            part = np.empty((counts[k], 3), np.int32)
            find_runs(part, first, end)
        part[:, 0] += first // 2
        found[k] = part[: counts[k]]
    return found[0] if len(found) == 1 else np.concatenate(found)


def _lay_out(finest: NDArray[np.int32], table: Table) -> tuple[NDArray[np.int32], NDArray[np.int64]]:
    """Runs and segments of all levels."""
    n = len(finest)
    scratch = np.empty((2, n, 3), np.int32)
    room = 2 * n + 16 * len(table)  # most often: a level has half the runs of the one before it
    while True:
        runs, segments = np.empty((room, 3), np.int32), np.empty((room, 4), np.int64)
        distances = RUN_GAP, SEGMENT_GAP, LONGEST_SEGMENT
        needed = int(setup.lay_out(runs, segments, table, scratch, finest, *distances))
        if needed <= room:
            return runs, segments
        room = needed


def _factor(diagonal: Float32, edge_e: Float32, edge_s: Float32, table: Table, n: int) -> Coarsest:
    """Cholesky factor of the matrix of the last level, which has n unknowns."""
    height, width = int(table[-2, HEIGHT]), int(table[-2, WIDTH])
    band = np.zeros((n, min(height, width) + 1))
    cells, number = np.empty(n, np.int64), np.empty(height * width, np.int64)
    where = diagonal, edge_e, edge_s, table, len(table) - 2
    return Coarsest(band, cells, float(setup.factor_coarsest(band, cells, np.ones(n), number, *where)))


def plain_level(values: Float32, table: Table, level: int, skipped: int = 0) -> Float32:
    """A level of a one-channel field as a (height, width) array; `skipped`: length of the levels it leaves out."""
    height, width, rows, cols, stride, size, offset = (int(n) for n in table[level, : OFFSET + 1])
    quarters = values[offset - skipped : offset - skipped + 4 * size].reshape(4, rows + 2, stride)[
        :, 1:-1, :cols
    ]
    grid = np.zeros((2 * rows, 2 * cols), np.float32)
    for quarter in range(4):
        grid[quarter // 2 :: 2, quarter % 2 :: 2] = quarters[quarter]
    return grid[:height, :width]
