"""Parts of a region that lie far apart: each is solved for itself, in a window of its own.

The fields of a solver are as large as the region's bounding box, or a third larger.  Two small disks in opposite
corners of a large image would touch memory, and pass over rows, that have nothing to do with either of them.  What
has no neighbours in common shares no equation: each window is a problem of its own, with its own grids and cycles.
"""

from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from solvers.canvas import Canvas, Correct, Equations, Rim, Share, Values
from solvers.problem import PoissonProblem

# Pixels of a bounding box up to which it is small anyway,
SMALL = 1 << 20
# and share of it that windows may fill together to be worth the trouble.
MUCH_SMALLER = 0.5
TILE = 64  # pixels: unknowns nearer to each other than this may be put into one window


class Box(NamedTuple):
    """Rows top ... bottom and columns left ... right of an image; `top` is even."""

    top: int
    bottom: int
    left: int
    right: int

    @property
    def pixels(self) -> int:
        """How many there are."""
        return (self.bottom - self.top) * (self.right - self.left)

    def of(self, array: NDArray[Any]) -> NDArray[Any]:
        """The box of an (H, W[, C]) array; a view."""
        return array[self.top : self.bottom, self.left : self.right]


def boxes(region: NDArray[np.bool_]) -> list[Box]:
    """Windows that hold all unknowns, none of which has a neighbour in another one; a single one if that is cheaper.

    Parameters
    ----------
    region : (H, W) bool
        True = unknown.

    Returns
    -------
    list of Box
        Each with a ring of known pixels around its unknowns, as far as the image goes.  They may overlap there.
    """
    height, width = region.shape
    whole = [Box(0, height, 0, width)]
    if region.size <= SMALL:
        return whole
    rows, cols = (-(-side // TILE) for side in (height, width))
    occupied = np.zeros((rows, cols), np.bool_)
    for row in range(rows):
        near = region[row * TILE : (row + 1) * TILE].any(0)
        occupied[row] = np.logical_or.reduceat(near, np.arange(0, width, TILE))
    if np.count_nonzero(occupied) > MUCH_SMALLER * occupied.size:
        return whole
    found = [_box_of(region, *tiles) for tiles in _merged(_connected(occupied))]
    return found if sum(box.pixels for box in found) <= MUCH_SMALLER * region.size else whole


Tiles = tuple[int, int, int, int]  # rows first ... end, columns first ... end


def _connected(occupied: NDArray[np.bool_]) -> list[Tiles]:
    """Bounding boxes of tiles that touch each other, corners included."""
    left = set(zip(*(axis.tolist() for axis in np.nonzero(occupied)), strict=True))
    found = []
    while left:
        seed = left.pop()
        stack, group = [seed], [seed]
        while stack:
            row, col = stack.pop()
            for near in [(r, c) for r in (row - 1, row, row + 1) for c in (col - 1, col, col + 1)]:
                if near in left:
                    left.remove(near)
                    stack.append(near)
                    group.append(near)
        r, c = zip(*group, strict=True)
        found.append((min(r), max(r) + 1, min(c), max(c) + 1))
    return sorted(found)


def _merged(groups: list[Tiles]) -> list[Tiles]:
    """The same, with boxes that overlap or touch made into one, until none do."""
    done: list[Tiles] = []
    waiting = list(groups)
    while waiting:
        box = waiting.pop()
        for k, other in enumerate(done):
            if box[0] <= other[1] and other[0] <= box[1] and box[2] <= other[3] and other[2] <= box[3]:
                del done[k]
                pairs = list(zip(box, other, strict=True))
                waiting.append((min(pairs[0]), max(pairs[1]), min(pairs[2]), max(pairs[3])))
                break
        else:
            done.append(box)
    return sorted(done)


def _box_of(region: NDArray[np.bool_], first: int, end: int, low: int, high: int) -> Box:
    """The unknowns in a box of tiles, with a ring of pixels around them: the tiles beside the box hold no others."""
    height, width = region.shape
    tiles = region[first * TILE : end * TILE, low * TILE : high * TILE]
    rows, cols = np.flatnonzero(tiles.any(1)), np.flatnonzero(tiles.any(0))
    top = max(first * TILE + int(rows[0]) - 1, 0) & ~1
    bottom = min(first * TILE + int(rows[-1]) + 2, height)
    left, right = max(low * TILE + int(cols[0]) - 1, 0), min(low * TILE + int(cols[-1]) + 2, width)
    return Box(top, bottom, left, right)


def part_of(problem: PoissonProblem, region: NDArray[np.bool_], box: Box) -> PoissonProblem:
    """The problem in a box, whose unknowns are those of `region`."""
    if box.pixels == problem.region.size and region is problem.region:
        return problem
    return PoissonProblem.on_canvas(
        np.ascontiguousarray(box.of(region)),
        _Part(problem.canvas, box),
        level=problem.level,
        screening=problem.screening,
    )


def together(parts: Sequence[tuple[Box, Correct]], shape: tuple[int, ...]) -> Correct:
    """What adds the corrections of several boxes to rows of the image, which has this height and width."""
    if len(parts) == 1 and parts[0][0].pixels == shape[0] * shape[1]:
        return parts[0][1]

    def add(guess: Values, top: int) -> None:
        for box, correct in parts:
            first, end = max(box.top, top), min(box.bottom, top + len(guess))
            if first < end:
                there = guess[first - top : end - top, box.left : box.right]
                values = there.copy()
                correct(values, first - box.top)
                there[:] = values

    return add


class _Part(NamedTuple):
    """A box of a canvas, as a canvas to take equations from."""

    canvas: Canvas
    box: Box

    @property
    def shape(self) -> tuple[int, int, int]:
        return self.box.bottom - self.box.top, self.box.right - self.box.left, self.canvas.shape[2]

    @property
    def small_integers(self) -> bool:
        return self.canvas.small_integers

    def equations(self, first: int, end: int) -> Iterator[Equations]:
        box = self.box
        # What an even row number begins must end with one, or with the image.
        odd = (box.top + end) & 1 and box.top + end < self.canvas.shape[0]
        for band in self.canvas.equations(box.top + first, box.top + end + odd):
            top = max(band.top, box.top)
            rows = slice(top - band.top, box.bottom - band.top)
            cols, pairs = slice(box.left, box.right), slice(box.left, box.right - 1)
            yield band._replace(
                first=band.first - box.top,
                end=min(band.end - box.top, end),
                top=top - box.top,
                values=_cut(band.values, rows, cols),
                across=_cut(band.across, rows, pairs),
                down=_cut(band.down, slice(rows.start, rows.stop - 1), cols),
                rhs=_cut(band.rhs, rows, cols),
            )

    def rim(self) -> Rim | None:
        rim = self.canvas.rim()
        if rim is None:
            return None
        row, col, box = rim.row - self.box.top, rim.col - self.box.left, self.box
        here = (row >= 0) & (row < box.bottom - box.top) & (col >= 0) & (col < box.right - box.left)
        return Rim(row[here], col[here], rim.values[here])

    def paint(self, correct: Correct, share: Share) -> NDArray[Any]:
        raise AssertionError("the whole canvas is painted, not a part of it")

    def paint_at(self, place: NDArray[np.int64], correction: NDArray[np.float64]) -> NDArray[Any]:
        raise AssertionError("the whole canvas is painted, not a part of it")


def _cut(values: Values | None, rows: slice, cols: slice) -> Any:
    return None if values is None else np.ascontiguousarray(values[rows, cols])
