"""An edit as the solver sees it: the equations under the window, and the picture that their solution is painted on.

Stored values become floats, and floats stored values, in bands of a few rows (`solvers.canvas`): beside the pictures
themselves nothing here is as large as a picture.
"""

from collections.abc import Iterator
from time import perf_counter
from typing import Any

import numpy as np
from numpy.typing import NDArray

from poisson_cli.editing import tone
from poisson_cli.editing.guidance import Field
from poisson_cli.editing.layers import Band, Layer
from poisson_cli.editing.placement import Placement
from solvers.canvas import Correct, Equations, bands


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

    Attributes
    ----------
    clipped : int
        Values that left the range of the picture and were clipped, once it is painted.
    seconds : dict
        Spent on "guidance" and on "paste" so far.
    """

    def __init__(
        self, destination: NDArray[Any], placement: Placement, source: Layer | None, field: Field
    ) -> None:
        self._picture = destination
        self._placement = placement
        self._region = placement.region
        self._destination = Layer.of_destination(destination, placement)
        self._source = source
        self._field = field
        self._shift = self._mean_shift() if self._region.all() else None
        self.clipped = 0
        self.seconds = {"guidance": 0.0, "paste": 0.0}

    @property
    def shape(self) -> tuple[int, int, int]:
        """H, W, C of the window."""
        height, width = self._region.shape
        return height, width, self._destination.channels

    @property
    def small_integers(self) -> bool:
        """True for pictures of integers, unless a luminance was made of them."""
        return self._picture.dtype.kind == "u" and not (self._source is not None and self._source.monochrome)

    def equations(self) -> Iterator[Equations]:
        """f* - a outside Omega, zero in it, and the field's w."""
        height = self.shape[0]
        for first, end in self._bands():
            start = perf_counter()
            top, bottom = max(first - 1, 0), min(end + 1, height)
            band = self._band(top, bottom)
            w = self._field.beyond(band) if self._field.beyond is not None else None
            f, base = band.destination, self._field.base(band)
            np.copyto(_pixels(f), _pixels(base), where=self._region[top:bottom])
            f -= base
            across, down = (None, None) if w is None else (w.across, w.down)
            self.seconds["guidance"] += perf_counter() - start
            yield Equations(first, end, top, f, across, down)

    def paint(self, correct: Correct) -> NDArray[Any]:
        """The destination with a + u in Omega, rounded and clipped as its depth asks for."""
        start = perf_counter()
        self.clipped = 0
        picture = self._picture.copy()
        window = self._placement.on_destination(picture)
        window = window.reshape(self.shape) if window.ndim == 2 else window
        for first, end in self._bands():
            if not self._region[first:end].any():
                continue  # between parts that lie far apart
            base = self._field.base(self._band(first, end))
            if self._shift is not None:
                base += self._shift
            correct(base, first)
            # a is in range, as f* and g are: only values of Omega can be counted.
            self.clipped += tone.count_clipped(base, picture.dtype)
            stored = tone.to_storage(base, picture.dtype)
            np.copyto(_pixels(window[first:end]), _pixels(stored), where=self._region[first:end])
        self.seconds["paste"] += perf_counter() - start
        return picture

    def boundary_mismatch(self) -> tuple[float, ...] | None:
        """Per channel, the mean of |f* - g| over the boundary, in levels; None where no boundary pixel has a source."""
        if self._source is None:
            return None
        there = np.nonzero(self._placement.boundary() & self._placement.has_source())
        if there[0].size == 0:
            return None
        known, source = (
            layer.at(*there).astype(self._destination.dtype) for layer in (self._destination, self._source)
        )
        mean = np.abs(known - source).mean(0, dtype=np.float64) / tone.level(self._picture.dtype)
        return tuple(float(m) for m in mean)

    def _mean_shift(self) -> NDArray[Any]:
        """The mean of f* less that of a, per channel."""
        height, width, channels = self.shape
        total = np.zeros(channels)
        for first, end in self._bands():
            band = self._band(first, end)
            for sign, picture in ((1, band.destination), (-1, self._field.base(band))):
                total += sign * picture.sum((0, 1), dtype=np.float64)
        return (total / (height * width)).astype(self._destination.dtype)

    def _band(self, first: int, end: int) -> Band:
        return Band(self._destination, self._source, first, end)

    def _bands(self) -> Iterator[tuple[int, int]]:
        height, width, channels = self.shape
        return bands(height, width * channels)


def _pixels(values: NDArray[Any]) -> NDArray[np.void]:
    """(n, w, C) as (n, w) whole pixels: copied by a mask of theirs, without a mask for each channel."""
    pixel = np.dtype((np.void, values.shape[2] * values.itemsize))
    whole: NDArray[np.void] = values.view(pixel)[:, :, 0]
    return whole
