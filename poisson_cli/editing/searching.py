"""Where in a picture there is a patch whose surroundings look like those of the selection.

What is compared is a rim of pixels R around the selection: an offset o costs, added up over the channels,

    variance over R of d + 1/4 (mean over R of d)^2,    d = f(p) - f(p + o);

and a quarter of the variance of the patch itself, so that of places with like surroundings the one with nothing in it
is taken.  The variance is what cannot be evened out by a constant.  The mean can be, and with no weight at all it lets
in places of quite another colour: as the rim is never matched perfectly, a flat wall then beats cloth for cloth, and
its colour bleeds.  With all of its weight, places with another light on them lose to unlike ones.  Multiplied out,
every sum is a correlation, and Fourier transforms give them for all offsets at once.
"""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from poisson_cli.editing import tone
from poisson_cli.editing.placement import Placement
from poisson_cli.errors import InputError

# Pixels around the selection that are compared.
RIM = 4
# Weight of what a constant can even out.  On photographs all from .1 to .5 choose much the same.
EVEN = 0.25
# Weight of the variance of the patch.
INSIDE = 0.25
# Pixels that are searched at once: larger pictures are reduced.
SEARCHED = 1 << 20
# Places that are looked at pixel by pixel after a search at reduced size, and pixels of the rim looked at for each.
PLACES = 8
LOOKED_AT = 1 << 12
# Offsets whose mean squared difference is larger by this share at most, or by this much (square levels), are equally
# good: the rounding errors of a Fourier transform are smaller than that.
SHARE = 1e-6
NOISE = 1e-5

Bool = NDArray[np.bool_]
Float64 = NDArray[np.float64]
Offset = tuple[int, int]


def best_offset(image: NDArray[Any], placement: Placement, reach: int | None = None) -> Offset:
    """The offset (row, column) from the selection to the patch that fits best; see `heal`.

    Parameters
    ----------
    image : (H, W) or (H, W, C) array
    placement : Placement
        Of the selection on the image.
    reach : int, optional
        The largest offset in rows and in columns.

    Raises
    ------
    InputError
        If there is no room for a patch.
    """
    if reach is not None and reach < 1:
        raise InputError(f"reach is {reach}, but must be at least 1 pixel")
    tone.check_values("image", image)
    around = _around(image, placement, reach)
    step = max(1, math.ceil(math.sqrt(around.region.size / SEARCHED)))
    search = _costs(around, step, reach)
    if search.cost.size == 0 or not np.isfinite(search.cost).any():
        raise InputError(
            "there is no room for a patch of the selection's size beside it: select less, search farther, or say where "
            "to take the patch from"
        )
    return search.best() if step == 1 else _refined(around, search.best_places(), step)


@dataclass(frozen=True, eq=False)
class _Surroundings:
    """The part of the picture that is searched: stored values (h, w, C), the selection, and a level."""

    stored: NDArray[Any]
    region: Bool
    level: float


@dataclass(frozen=True, eq=False)
class _Costs:
    """Costs, (n, m) square levels, of the offsets rows x cols; infinite where a patch cannot be.

    `inside` is the share in them that comes from the patch itself.
    """

    rows: NDArray[np.intp]
    cols: NDArray[np.intp]
    cost: Float64
    inside: Float64

    def best(self) -> Offset:
        """The offset that costs least; of several, the nearest."""
        least = self.cost.min()
        at = np.argwhere(self.cost <= least + max(SHARE * least, NOISE))
        offsets = [(int(self.rows[i]), int(self.cols[j])) for i, j in at]
        return min(offsets, key=lambda o: (o[0] ** 2 + o[1] ** 2, o))

    def best_places(self) -> list[tuple[Offset, float]]:
        """The offsets that cost least, none of them beside another, and their patches' shares."""
        cost = self.cost.copy()
        places: list[tuple[Offset, float]] = []
        while len(places) < PLACES and np.isfinite(cost).any():
            i, j = np.unravel_index(cost.argmin(), cost.shape)
            places.append(((int(self.rows[i]), int(self.cols[j])), float(self.inside[i, j])))
            cost[max(i - 1, 0) : i + 2, max(j - 1, 0) : j + 2] = np.inf
        return places


def _around(image: NDArray[Any], placement: Placement, reach: int | None) -> _Surroundings:
    """As much of the picture as patches and rims within reach can touch."""
    row, col, height, width = placement.rectangle
    far = max(image.shape) if reach is None else reach + RIM
    top, left = max(0, row - far), max(0, col - far)
    stored = image[top : row + height + far, left : col + width + far]
    region = np.zeros(stored.shape[:2], np.bool_)
    first, leftmost = placement.top - top, placement.left - left
    part = placement.region
    region[first : first + part.shape[0], leftmost : leftmost + part.shape[1]] = part
    return _Surroundings(stored.reshape(*region.shape, -1), region, tone.level(image.dtype))


def _costs(around: _Surroundings, step: int, reach: int | None) -> _Costs:
    """Of all offsets that are multiples of `step`, with `step` x `step` pixels as one.

    Where pixels are taken together a patch keeps one of them more from the edge of the picture and from the selection:
    there may be a better offset beside it.
    """
    f, covered = _reduced(around, step)
    height, width = covered.shape
    rim = _grown(covered, max(1, -(-RIM // step))) & ~covered
    whole = around.region.shape[0] // step, around.region.shape[1] // step  # what is not cut off by the edge
    rim[whole[0] :] = False
    rim[:, whole[1] :] = False
    needed = covered | rim
    margin = 0 if step == 1 else 1
    ranges = []
    for axis, length in enumerate(whole):
        occupied = np.flatnonzero(needed.any(1 - axis))
        offsets = np.arange(margin - occupied[0], length - margin - occupied[-1])
        ranges.append(offsets if reach is None else offsets[np.abs(offsets) * step <= reach])
    rows, cols = ranges

    shape = (height, width)
    weights = np.fft.rfft2(rim.astype(np.float64))

    def correlated(a: NDArray[np.complex128], b: Float64) -> Float64:
        """Sum over p of a(p) b(p + o).  What wraps around belongs to offsets that are not asked for."""
        everywhere = np.fft.irfft2(a.conj() * np.fft.rfft2(b), shape)
        asked: Float64 = everywhere[np.ix_(rows % height, cols % width)]
        return asked

    touched = np.fft.rfft2(_grown(needed, margin).astype(np.float64))
    meets = correlated(touched, covered.astype(np.float64)) > 0.5
    number, area = int(np.count_nonzero(rim)), int(np.count_nonzero(covered))
    if number == 0:  # all is selected, but for what touches the edge
        return _Costs(rows, cols, np.full(meets.shape, np.inf), np.zeros(meets.shape))
    squares, patch = (f * f).sum(2), np.fft.rfft2(covered.astype(np.float64))
    cost = correlated(weights, squares)
    inside = correlated(patch, squares) / area
    for channel in range(f.shape[2]):
        c = f[:, :, channel]
        here = np.where(rim, c, 0.0)
        cost += (here * here).sum() - 2 * correlated(np.fft.rfft2(here), c)
        cost -= (1 - EVEN) * (here.sum() - correlated(weights, c)) ** 2 / number
        inside -= (correlated(patch, c) / area) ** 2
    inside *= INSIDE
    cost = cost / number + inside
    cost[meets] = np.inf
    return _Costs(rows, cols, cost, inside)


def _reduced(around: _Surroundings, step: int) -> tuple[Float64, Bool]:
    """Means of step x step pixels, in levels, less the mean of all; and whether any of the pixels is selected."""
    height, width, channels = around.stored.shape
    shape = -(-height // step), -(-width // step)
    f = np.empty((*shape, channels))
    covered = np.empty(shape, np.bool_)
    starts = np.arange(0, width, step)
    lengths = np.diff(starts, append=width)
    for row in range(shape[0]):
        rows = slice(row * step, (row + 1) * step)
        strip = around.stored[rows].sum(0, dtype=np.float64) / len(around.stored[rows])
        f[row] = np.add.reduceat(strip, starts, axis=0) / lengths[:, np.newaxis]
        covered[row] = np.logical_or.reduceat(around.region[rows].any(0), starts)
    f /= around.level
    f -= f.mean((0, 1))
    return f, covered


def _grown(region: Bool, pixels: int) -> Bool:
    """The region and what lies within so many steps to a neighbour."""
    grown = region.copy()
    for _ in range(pixels):
        before = grown.copy()
        grown[1:] |= before[:-1]
        grown[:-1] |= before[1:]
        grown[:, 1:] |= before[:, :-1]
        grown[:, :-1] |= before[:, 1:]
    return grown


def _refined(around: _Surroundings, places: list[tuple[Offset, float]], step: int) -> Offset:
    """The best offset less than `step` pixels away from one of the places (in units of `step`)."""
    whole = tuple(slice(length // step * step) for length in around.region.shape)  # as in `_costs`
    rows, cols = np.nonzero((_grown(around.region, RIM) & ~around.region)[whole])
    every = -(-len(rows) // LOOKED_AT)
    rows, cols = rows[::every], cols[::every]
    f = around.stored[rows, cols] / around.level
    near = range(1 - step, step)
    best: list[tuple[float, int, Offset]] = []
    for place, inside in places:
        for offset in ((place[0] * step + i, place[1] * step + j) for i in near for j in near):
            d = f - around.stored[rows + offset[0], cols + offset[1]] / around.level
            cost = float((d.var(0) + EVEN * d.mean(0) ** 2).sum()) + inside
            best.append((cost, offset[0] ** 2 + offset[1] ** 2, offset))
    return min(best)[2]
