"""An edit as the solver sees it: the equations under the window, and the picture that their solution is painted on.

Stored values become floats, and floats stored values, in bands of a few rows (`solvers.canvas`): beside the pictures
themselves nothing here is as large as a picture.
"""

from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from poisson_cli.editing import tone
from poisson_cli.editing.guidance import Field
from poisson_cli.editing.layers import Band, Layer
from poisson_cli.editing.placement import Placement
from poisson_cli.editing.stopwatch import Stopwatch
from solvers.canvas import Correct, Equations, Share, bands, with_channels


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
    guidance_time, paste_time : Stopwatch
        For making equations, and for painting.
    """

    def __init__(
        self, destination: NDArray[Any], placement: Placement, source: Layer | None, field: Field
    ) -> None:
        self._picture = destination
        self._placement = placement
        self._region = placement.region
        self._destination = Layer.of_destination(destination, placement)
        self._source = source
        self._idle = [(self._destination, source)]
        self._field = field
        self._shift = self._mean_shift() if self._region.all() else None
        self.clipped = 0
        self.guidance_time, self.paste_time = Stopwatch(), Stopwatch()

    @property
    def shape(self) -> tuple[int, int, int]:
        """H, W, C of the window."""
        height, width = self._region.shape
        return height, width, self._destination.channels

    @property
    def small_integers(self) -> bool:
        """True for pictures of integers, unless a luminance was made of them."""
        return self._picture.dtype.kind == "u" and not (self._source is not None and self._source.monochrome)

    def equations(self, first: int, end: int) -> Iterator[Equations]:
        """f* - a outside Omega, zero in it, and the field's w."""
        height = self.shape[0]
        for low, high, layers in self._bands(first, end):
            with self.guidance_time:
                top, bottom = max(low - 1, 0), min(high + 1, height)
                band = Band(*layers, top, bottom)
                w = self._field.beyond(band) if self._field.beyond is not None else None
                f, base = band.destination, self._field.base(band)
                np.copyto(_pixels(f), _pixels(base), where=self._region[top:bottom])
                f -= base
                across, down = (None, None) if w is None else (w.across, w.down)
            yield Equations(low, high, top, f, across, down)

    def paint(self, correct: Correct, share: Share) -> NDArray[Any]:
        """The destination with a + u in Omega, rounded and clipped as its depth asks for."""
        with self.paste_time:
            top = self._placement.top
            bottom = top + len(self._region)
            picture = np.empty(self._picture.shape, self._picture.dtype)
            picture[:top], picture[bottom:] = self._picture[:top], self._picture[bottom:]
            window = with_channels(self._placement.on_destination(picture))

            def rows(first: int, end: int) -> int:
                """How many values were clipped."""
                clipped = 0
                for low, high, layers in self._bands(first, end):
                    picture[top + low : top + high] = self._picture[top + low : top + high]
                    base = self._field.base(Band(*layers, low, high))
                    if self._shift is not None:
                        base += self._shift
                    correct(base, low)
                    # a is in range, as f* and g are: only values of Omega can be counted.
                    clipped += tone.count_clipped(base, picture.dtype)
                    stored = tone.to_storage(base, picture.dtype)
                    np.copyto(_pixels(window[low:high]), _pixels(stored), where=self._region[low:high])
                return clipped

            self.clipped = sum(share(rows))
        return picture

    def boundary_mismatch(self) -> tuple[float, ...] | None:
        """Per channel, the mean of |f* - g| over the boundary, in levels; None where no boundary pixel has a source."""
        if self._source is None:
            return None
        there = self._placement.boundary_on_source()
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
        for first, end, layers in self._bands(0, height):
            band = Band(*layers, first, end)
            for sign, picture in ((1, band.destination), (-1, self._field.base(band))):
                total += sign * picture.sum((0, 1), dtype=np.float64)
        return (total / (height * width)).astype(self._destination.dtype)

    def _bands(self, first: int, end: int) -> Iterator[tuple[int, int, tuple[Layer, Layer | None]]]:
        """First and end row of each band of these rows, and both pictures: they are nobody else's."""
        _, width, channels = self.shape
        try:
            layers = self._idle.pop()
        except IndexError:  # all in use, by other threads
            layers = self._destination.apart(), None if self._source is None else self._source.apart()
        for low, high in bands(first, end, width * channels):
            yield low, high, layers
        self._idle.append(layers)


def _pixels(values: NDArray[Any]) -> NDArray[np.void]:
    """(n, w, C) as (n, w) whole pixels: copied by a mask of theirs, without a mask for each channel."""
    pixel = np.dtype((np.void, values.shape[2] * values.itemsize))
    whole: NDArray[np.void] = values.view(pixel)[:, :, 0]
    return whole
