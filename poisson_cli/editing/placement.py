"""Where an edit happens: the selection made into Omega, and the window of the destination that is worked on."""

import operator
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Literal, get_args

import numpy as np
from numpy.typing import NDArray

from poisson_cli.errors import InputError
from solvers.kernels.setup import find_extent, find_rim

MaskOn = Literal["source", "destination"]
Pixels = tuple[NDArray[np.intp], NDArray[np.intp]]

# Share of the window below which a region is specks and strokes: most of its pixels lie on the boundary.
SPARSE = 0.25


@dataclass(frozen=True, eq=False)
class Placement:
    """Omega on the destination, and the source laid under it.

    Attributes
    ----------
    top, left : int
        Where the window begins on the destination: Omega's bounding box and one ring of pixels around it, as far as
        the destination reaches.  Where the ring is missing, Omega touches the edge of the image.
    region : (h, w) bool
        Omega in the window, True = unknown.
    unknowns : int
        How many pixels that is.
    rectangle : (row, column, height, width)
        Omega's bounding box on the destination.
    offset : (row, column)
        The source's top left corner on the destination.
    source_shape : (H, W)
    """

    top: int
    left: int
    region: NDArray[np.bool_]
    unknowns: int
    rectangle: tuple[int, int, int, int]
    offset: tuple[int, int]
    source_shape: tuple[int, int]

    def on_destination(self, destination: NDArray[Any]) -> NDArray[Any]:
        """The window of the destination; a view."""
        height, width = self.region.shape
        return destination[self.top : self.top + height, self.left : self.left + width]

    def source_window(self) -> tuple[slice, slice, tuple[tuple[int, int], tuple[int, int]]]:
        """Rows and columns of the source under the window, and how many the window has beyond them on each side.

        Omega itself lies on the source.  Only the ring can leave it; the source is taken to continue there with the
        value at its edge, and the gradient of a pixel pair that leaves the source is thus zero.
        """
        slices, padding = [], []
        for axis, start in enumerate((self.top - self.offset[0], self.left - self.offset[1])):
            stop = start + self.region.shape[axis]
            low, high = max(start, 0), min(stop, self.source_shape[axis])
            slices.append(slice(low, high))
            padding.append((low - start, stop - high))
        return slices[0], slices[1], (padding[0], padding[1])

    @cached_property
    def boundary(self) -> Pixels:
        """Rows and columns of the window's pixels outside Omega with a 4-neighbour in it, row by row."""
        height, width = self.region.shape
        words, marked = np.zeros((2, width // 8 + 1), np.int64)
        room = 4 * (height + width)  # enough for what a hand draws; if it is not, the count is known then
        if self.unknowns < SPARSE * height * width:
            room = min(4 * self.unknowns, height * width)
        while True:
            rows, cols = np.empty(room + 1, np.int64), np.empty(room + 1, np.int64)
            count = int(find_rim(rows, cols, self.region, words, words.view(np.uint8), marked))
            if count <= room:
                return rows[:count], cols[:count]
            room = count

    def boundary_on_source(self) -> Pixels:
        """Those of them that lie on the source."""
        _, _, ((north, south), (west, east)) = self.source_window()
        if not (north or south or west or east):
            return self.boundary
        (row, col), (height, width) = self.boundary, self.region.shape
        there = (north <= row) & (row < height - south) & (west <= col) & (col < width - east)
        return self.boundary if there.all() else (row[there], col[there])


def place(
    destination_shape: tuple[int, ...],
    source_shape: tuple[int, ...],
    mask: NDArray[Any],
    *,
    offset: tuple[int, int] = (0, 0),
    mask_on: MaskOn = "source",
) -> Placement:
    """Lays a source on a destination and clips the selection to where both have pixels.

    Parameters
    ----------
    destination_shape, source_shape : (H, W, ...)
    mask : (H, W) array
        True or non-zero = edit.  Has the source's height and width, or the destination's: see `mask_on`.
    offset : (row, column)
        The source's top left corner on the destination; negative allowed, overhang is clipped.
    mask_on : {"source", "destination"}
        Whose pixels `mask` speaks of.

    Raises
    ------
    InputError
        If the mask has another size, selects nothing, or selects nothing that lies on both pictures.
    """
    if mask_on not in get_args(MaskOn):
        raise InputError(f"mask_on is {mask_on!r}, but must be 'source' or 'destination'")
    mask = np.asarray(mask)
    expected = (source_shape if mask_on == "source" else destination_shape)[:2]
    if mask.shape != expected:
        raise InputError(
            f"the mask is {_size(mask.shape)} but the {mask_on} is {_size(expected)}: give a mask of that size"
            f"{_other_way_out(mask.shape, source_shape, destination_shape, mask_on)}"
        )
    if mask.dtype.kind == "f" and np.isnan(mask).any():
        raise InputError("the mask has NaN values: give one that is zero or not zero everywhere")
    try:
        row, col = (operator.index(n) for n in offset)
    except (TypeError, ValueError):
        raise InputError(f"offset is {offset!r}, but must be two whole numbers: (row, column)") from None

    # The part of the destination that the source covers, in the mask's own coordinates.
    shift = (row, col) if mask_on == "source" else (0, 0)
    low = [max(0, n) for n in (row, col)]
    high = [
        min(d, n + s) for d, s, n in zip(destination_shape[:2], source_shape[:2], (row, col), strict=True)
    ]
    covered = mask[
        max(0, low[0] - shift[0]) : max(0, high[0] - shift[0]),
        max(0, low[1] - shift[1]) : max(0, high[1] - shift[1]),
    ]
    selected = np.ascontiguousarray(covered if covered.dtype == np.bool_ else covered != 0)
    columns = np.zeros(selected.shape[1], np.uint8)
    first_row, end_row, unknowns = (int(n) for n in find_extent(columns, selected))
    if unknowns == 0:
        if not np.any(mask):
            raise InputError("the selection is empty: no pixel of the mask is selected")
        raise InputError(
            f"the selection lies wholly outside: with its corner at {col},{row} the source ({_size(source_shape)}) "
            f"has no selected pixel on the destination ({_size(destination_shape)}); choose another position"
        )
    cols = np.flatnonzero(columns)
    first_col, end_col = int(cols[0]), int(cols[-1]) + 1
    rectangle = (low[0] + first_row, low[1] + first_col, end_row - first_row, end_col - first_col)

    top, left = max(0, rectangle[0] - 1), max(0, rectangle[1] - 1)
    bottom = min(destination_shape[0], rectangle[0] + rectangle[2] + 1)
    right = min(destination_shape[1], rectangle[1] + rectangle[3] + 1)
    region = _window(selected, (top - low[0], bottom - low[0]), (left - low[1], right - low[1]))
    size = source_shape[0], source_shape[1]
    return Placement(top, left, region, unknowns, rectangle, (row, col), size)


def _window(mask: NDArray[np.bool_], rows: tuple[int, int], cols: tuple[int, int]) -> NDArray[np.bool_]:
    """A copy of some rows and columns, from the first up to the second; False where they lie beyond the mask."""
    inside = [
        slice(max(first, 0), min(end, size))
        for (first, end), size in zip((rows, cols), mask.shape, strict=True)
    ]
    part = mask[inside[0], inside[1]]
    shape = rows[1] - rows[0], cols[1] - cols[0]
    if part.shape == shape:
        return part.copy()
    whole = np.zeros(shape, np.bool_)
    row, col = inside[0].start - rows[0], inside[1].start - cols[0]
    whole[row : row + part.shape[0], col : col + part.shape[1]] = part
    return whole


def _size(shape: tuple[int, ...]) -> str:
    """A size as people say it, width first."""
    return f"{shape[1]}x{shape[0]}" if len(shape) >= 2 else f"{len(shape)}-dimensional"


def _other_way_out(
    mask: tuple[int, ...], source: tuple[int, ...], destination: tuple[int, ...], mask_on: MaskOn
) -> str:
    other: MaskOn = "destination" if mask_on == "source" else "source"
    fits = (destination if other == "destination" else source)[:2] == mask
    return f", or say that it lies on the {other} (mask_on={other!r})" if fits else ""
