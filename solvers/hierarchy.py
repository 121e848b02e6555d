"""The grids of a region, from the pixels down to a grid that is solved directly.

Cell-centred 2 x 2 aggregation, a 5-point operator on every level.  A level has conductances between neighbouring cells,
and one *leak* per direction to the known values beside it.  A leak keeps its direction when cells merge, and with it
the known value's distance: that is what makes one coarse operator work on every region, thin and ragged ones included.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from solvers.kernels import setup
from solvers.layout import (
    FIRST_RUN,
    FIRST_SEGMENT,
    HEIGHT,
    LANES,
    OFFSET,
    QUARTER,
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


@dataclass(frozen=True)
class Coarsest:
    """The coarsest level's matrix, factored: see `kernels.cycle.solve_coarsest`."""

    band: NDArray[np.float64]
    cells: NDArray[np.int64]


@dataclass(frozen=True)
class Hierarchy:
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
    """
    arena, team = arena or Arena(), team or Team(1, region.size)
    region = np.ascontiguousarray(region, dtype=np.bool_)
    exact_runs = _all_runs(region, team)
    shapes = [(int(region.shape[0]), int(region.shape[1]))]
    while len(shapes) < len(exact_runs):
        shapes.append(((shapes[-1][0] + 1) // 2, (shapes[-1][1] + 1) // 2))
    table = layout_table(shapes)

    runs = [_whole_vectors(level_runs) for level_runs in exact_runs]
    table[1:, FIRST_RUN] = np.cumsum([len(r) for r in runs])
    segments = [
        _join(r, int(stride), int(first))
        for r, stride, first in zip(runs, table[:-1, STRIDE], table[:-1, FIRST_RUN], strict=True)
    ]
    table[1:, FIRST_SEGMENT] = np.cumsum([len(s) for s in segments])

    # Each operation writes at the places of its own runs or segments, and reads what the one before it left.
    size = field_size(table, 1)
    weight, diagonal = arena.zeros(size), arena.zeros(size)
    mass = arena.zeros(size if screening > 0 else 0)
    unknowns = [int(np.count_nonzero(region))]
    finest = team.pieces(runs[0], 1, unknowns[0])
    team.run(setup.weigh_region, [(weight, diagonal, region, part, table) for part in finest])
    if screening > 0:
        setup.screen_region(mass, weight, diagonal, segments[0], table, np.float32(screening))
    conductances = [arena.zeros(size - int(table[1, OFFSET])) for _ in range(6)]
    stride = int(table[0, STRIDE])

    def coarsen(part: NDArray[np.int32], level: int) -> None:
        if level == 1:
            setup.coarsen_region(*conductances, aligned_zeros(13 * stride), weight, part, table)
        else:
            setup.coarsen(*conductances, aligned_zeros(stride), part, table, level - 1)

    for level in range(1, len(shapes)):
        if unknowns[-1] <= EXACT_UNKNOWNS:
            break
        cells = unknowns[-1]
        team.run(coarsen, [(part, level) for part in team.pieces(runs[level - 1], 1, cells)])
        parts = team.pieces(segments[level], 0, cells)
        weighed = [(weight, diagonal, *conductances, part, table, level) for part in parts]
        unknowns.append(sum(int(n) for n in team.run(setup.weigh, weighed)))
        if screening > 0:
            setup.coarsen_mass(mass, aligned_zeros(stride), runs[level - 1], table, level - 1)
            setup.add_mass(weight, diagonal, mass, segments[level], table, level)

    # The depth was known only now: coarser levels, laid out above, are left out.
    n_levels = len(unknowns)
    table = table[: n_levels + 1]
    hierarchy = Hierarchy(
        region,
        table,
        np.concatenate(runs[:n_levels]),
        np.concatenate(segments[:n_levels]),
        weight,
        diagonal,
        conductances[0],
        conductances[1],
        tuple(unknowns),
        Coarsest(np.zeros((0, 1)), np.zeros(0, np.int64)),
    )
    return replace(hierarchy, coarsest=_factor(hierarchy))


def _all_runs(region: NDArray[np.bool_], team: Team) -> list[NDArray[np.int32]]:
    """Runs of all levels that there may be, finest first."""
    height, width = region.shape
    levels = [_finest_runs(region, team)]
    while min(height, width) > EXACT_SIDE:
        coarse = np.zeros_like(levels[-1])
        levels.append(coarse[: setup.coarsen_runs(coarse, levels[-1], RUN_GAP)])
        height, width = (height + 1) // 2, (width + 1) // 2
    return levels


def _finest_runs(region: NDArray[np.bool_], team: Team) -> NDArray[np.int32]:
    """Runs of the finest level."""
    bands = team.rows(len(region), region.size)
    none = np.zeros((0, 3), np.int32)
    counts = team.run(setup.find_runs, [(none, region[first:end], RUN_GAP) for first, end in bands])
    runs = np.zeros((sum(counts), 3), np.int32)
    parts = np.split(runs, np.cumsum(counts[:-1], dtype=np.intp))
    work = zip(parts, bands, strict=True)
    team.run(setup.find_runs, [(part, region[first:end], RUN_GAP) for part, (first, end) in work])
    for part, (first, _) in zip(parts, bands, strict=True):
        part[:, 0] += first // 2
    return runs


def _whole_vectors(runs: NDArray[np.int32]) -> NDArray[np.int32]:
    """The same runs with both ends moved outwards to multiples of `LANES`."""
    widened = runs.copy()
    widened[:, 1] &= -LANES
    widened[:, 2] = (widened[:, 2] + LANES - 1) & -LANES
    return widened


def _join(runs: NDArray[np.int32], stride: int, first_run: int) -> NDArray[np.int64]:
    """Segments of a level from its runs."""
    segments = np.zeros((len(runs), 4), np.int64)
    return segments[: setup.join_runs(segments, runs, stride, first_run, SEGMENT_GAP, LONGEST_SEGMENT)]


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


def _factor(hierarchy: Hierarchy) -> Coarsest:
    """Cholesky factor of the coarsest matrix, its cells numbered along the longer side to keep the band narrow."""
    level = hierarchy.n_levels - 1
    edge_e, edge_s, diagonal = hierarchy.operator(level)
    height, width = hierarchy.shape(level)
    if width > height:
        col, row = np.nonzero(diagonal.T)
    else:
        row, col = np.nonzero(diagonal)
    number = np.full((height + 1, width + 1), -1, np.int64)
    number[row, col] = np.arange(row.size)
    entries = []
    for edge, (down, right) in ((edge_e, (0, 1)), (edge_s, (1, 0))):
        r, c = np.nonzero(edge)
        p, q = number[r, c], number[r + down, c + right]
        entries.append((np.maximum(p, q), np.abs(p - q), edge[r, c]))
    bandwidth = max(int(distance.max(initial=0)) for _, distance, _ in entries)
    band = np.zeros((row.size, bandwidth + 1))
    band[:, 0] = diagonal[row, col]
    for i, distance, w in entries:
        band[i, distance] = -w
    setup.factor_band(band)
    stride, size = hierarchy.table[level, STRIDE], hierarchy.table[level, QUARTER]
    cells = (2 * (row % 2) + col % 2) * size + (row // 2 + 1) * stride + col // 2
    return Coarsest(band, cells.astype(np.int64))
