"""An edit as the solver sees it: the equations under the window, and the picture that their solution is painted on.

Stored values become working values, and working values stored ones, in bands of a few rows (`solvers.canvas`): beside
the pictures themselves nothing here is as large as a picture.
"""

from collections.abc import Iterator
from time import perf_counter
from typing import Any

import numpy as np
from numpy.typing import NDArray

from poisson_cli.editing import boundary, tone
from poisson_cli.editing.guidance import Field
from poisson_cli.editing.layers import Band, Layer, Points
from poisson_cli.editing.placement import Placement
from poisson_cli.editing.spaces import AsStored, Space
from solvers.canvas import Correct, Equations, Values, bands


class Window:
    """The canvas of an edit; see `solvers.canvas.Canvas`.

    With a, the picture whose gradient the field imports (`guidance`), it asks for u = f - a: known values f* - a
    outside Omega, first guess zero in it.  Where no pixel is known, a is shifted to the mean of f*.

    Parameters
    ----------
    destination : (H, W) or (H, W, C) array
        f*; not modified.
    placement : Placement
    source : Layer or None
        g; none where the field asks for none.
    field : Field
    space : Space or None
        The source layer's; the values as stored if none is given.
    robust : bool
        Make outliers among the known values count less (`boundary`).
    drawn : bool
        The equations are screened: what u is drawn to fixes its mean, and nothing is shifted.

    Attributes
    ----------
    clipped : int
        Values that left the range of the picture and were clipped, once it is painted.
    overshoot : float
        How far values left the range, in levels, once it is painted.
    seconds : dict
        Spent on "guidance" and on "paste" so far.
    """

    def __init__(
        self,
        destination: NDArray[Any],
        placement: Placement,
        source: Layer | None,
        field: Field,
        space: Space | None = None,
        *,
        robust: bool = False,
        drawn: bool = False,
    ) -> None:
        self.field = field
        self._picture = destination
        self._placement = placement
        self.region = placement.region
        self._destination = Layer.of_destination(destination, placement, space)
        self._source = source
        self.space = self._destination.space
        self._shift = self._mean_shift() if self.region.all() and not drawn else None
        self._rim = self._winsorised_rim() if robust else None
        self.clipped = 0
        self.overshoot = 0.0
        self.seconds = {"guidance": 0.0, "paste": 0.0}

    @property
    def shape(self) -> tuple[int, int, int]:
        """H, W, C of the window."""
        height, width = self.region.shape
        return height, width, self._destination.channels

    @property
    def small_integers(self) -> bool:
        """True for pictures of integers, as long as nothing was made of them that is none."""
        return (
            self._picture.dtype.kind == "u"
            and isinstance(self.space, AsStored)
            and self.field.small
            and self._rim is None
            and (self._source is None or self._source.look is None)
        )

    def equations(self) -> Iterator[Equations]:
        """f* - a outside Omega, zero in it, and the field's w."""
        height = self.shape[0]
        for first, end in self.bands():
            start = perf_counter()
            top, bottom = max(first - 1, 0), min(end + 1, height)
            band = self.band(top, bottom)
            w = self.field.beyond(band) if self.field.beyond is not None else None
            f, base = band.destination, self.field.base(band)
            np.copyto(_pixels(f), _pixels(base), where=self.region[top:bottom])
            f -= base
            if self._rim is not None:
                rows, cols, differences = self._rim
                here = slice(*np.searchsorted(rows, (top, bottom)))
                f[rows[here] - top, cols[here]] = differences[here]
            across, down = (None, None) if w is None else (w.across, w.down)
            self.seconds["guidance"] += perf_counter() - start
            yield Equations(first, end, top, f, across, down)

    def paint(self, correct: Correct) -> NDArray[Any]:
        """The destination with a + u in Omega, rounded and clipped as its depth asks for."""
        start = perf_counter()
        self.clipped, self.overshoot = 0, 0.0
        picture = self._picture.copy()
        window = self._placement.on_destination(picture)
        window = window.reshape(*self.region.shape, -1)
        for first, end in self.bands():
            working, before, stored = self.guess(first, end)
            correct(working, first)
            values = self.space.to_stored(working, before, stored)
            self._measure(values, first, end)
            np.copyto(
                _pixels(window[first:end]),
                _pixels(tone.to_storage(values, picture.dtype)),
                where=self.region[first:end],
            )
        self.seconds["paste"] += perf_counter() - start
        return picture

    def guess(self, first: int, end: int) -> tuple[Values, Values | None, Values | None]:
        """The first guess of f in rows of the window: a, where nothing is known of the mean of f*.

        And for spaces that must know (`Space.to_stored`), if a is a picture: its working values once more, and its
        stored ones.
        """
        base = self.field.base(self.band(first, end))
        before = stored = None
        layer = {None: None, "source": self._source, "destination": self._destination}[self.field.picture]
        if layer is not None and not isinstance(self.space, AsStored):
            before, stored = base.copy(), layer.stored_rows(first, end)
        if self._shift is not None:
            base += self._shift
        return base, before, stored

    def range(self) -> tuple[float, float]:
        """The range of the picture in stored values; wider where known values of a float picture leave it."""
        known = self._destination.stored_at(*np.nonzero(self._placement.boundary()))
        full = tone.FULL_SCALE[self._picture.dtype.type]
        return min(0.0, float(known.min(initial=0))), max(full, float(known.max(initial=full)))

    def boundary_mismatch(self) -> tuple[float, ...] | None:
        """Per channel, the mean of |f* - g| over the boundary, in levels; None where no boundary pixel has a source."""
        if self._source is None:
            return None
        there = np.nonzero(self._placement.boundary() & self._placement.has_source())
        if there[0].size == 0:
            return None
        mismatch = np.abs(self._destination.stored_at(*there) - self._source.stored_at(*there))
        return tuple(float(m) for m in mismatch.mean(0, dtype=np.float64) / tone.level(self._picture.dtype))

    def outliers(self) -> float | None:
        """The share of the boundary's pixels that are outliers, before anything is done about them."""
        rows, cols = np.nonzero(self._placement.boundary())
        if self._source is None or rows.size == 0:
            return None
        far = boundary.outlyingness(self._differences(rows, cols), self.space.level)
        return float(np.mean(far > 1))

    def _winsorised_rim(self) -> tuple[NDArray[np.intp], NDArray[np.intp], Values] | None:
        """Rows, columns and known values of the boundary's pixels, by rows; None if there are none."""
        rows, cols = np.nonzero(self._placement.boundary())
        if rows.size == 0:
            return None
        return rows, cols, boundary.winsorised(self._differences(rows, cols), self.space.level)

    def _differences(self, rows: NDArray[np.intp], cols: NDArray[np.intp]) -> Values:
        """f* - a at pixels of the window."""
        points = Points(self._destination, self._source, rows, cols)
        return points.destination - self.field.base(points)

    def _measure(self, values: Values, first: int, end: int) -> None:
        """Notes how far values of Omega leave the range, and how many are clipped."""
        dtype = self._picture.dtype
        if tone.excess(values, dtype) > 0:
            inside = values[self.region[first:end]]
            if inside.size:
                self.overshoot = max(self.overshoot, tone.excess(inside, dtype) / tone.level(dtype))
                self.clipped += tone.count_clipped(inside, dtype)

    def _mean_shift(self) -> NDArray[Any]:
        """The mean of f* less that of a, per channel."""
        height, width, channels = self.shape
        total = np.zeros(channels)
        for first, end in self.bands():
            band = self.band(first, end)
            for sign, picture in ((1, band.destination), (-1, self.field.base(band))):
                total += sign * picture.sum((0, 1), dtype=np.float64)
        return (total / (height * width)).astype(self.space.dtype)

    def band(self, first: int, end: int) -> Band:
        """Both pictures in rows of the window."""
        return Band(self._destination, self._source, first, end)

    def bands(self) -> Iterator[tuple[int, int]]:
        """First and end row of each band."""
        height, width, channels = self.shape
        return bands(height, width * channels)


def _pixels(values: NDArray[Any]) -> NDArray[np.void]:
    """(n, w, C) as (n, w) whole pixels: copied by a mask of theirs, without a mask for each channel."""
    pixel = np.dtype((np.void, values.shape[2] * values.itemsize))
    whole: NDArray[np.void] = values.view(pixel)[:, :, 0]
    return whole
