"""An edit as the solver sees it: the equations under the window, and the picture that their solution is painted on.

Stored values become working values, and working values stored ones, in bands of a few rows (`solvers.canvas`): beside
the pictures themselves nothing here is as large as a picture.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from poisson_cli.editing import boundary, tone
from poisson_cli.editing.boundary import NOTHING, Mismatch
from poisson_cli.editing.guidance import Field
from poisson_cli.editing.layers import Band, Layer, Points
from poisson_cli.editing.placement import Placement
from poisson_cli.editing.spaces import AsStored, Space
from poisson_cli.editing.stopwatch import Stopwatch
from solvers.canvas import Correct, Equations, Rim, Share, Values, bands, with_channels
from solvers.correction import Addition

# Pixels that are painted together, where they are scattered.
TOGETHER = 1 << 14

# How much larger bands are where a pixel needs few steps, so that what a band costs by itself hardly counts.
LARGER = 4

# The destination and the source.
Layers = tuple[Layer, Layer | None]


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
    guidance_time, paste_time : Stopwatch
        For making equations, and for painting.
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
        self._idle = [(self._destination, source)]
        self.space = self._destination.space
        nothing_known = placement.unknowns == self.region.size
        self._shift = self._mean_shift() if nothing_known and not drawn else None
        self._rim = self._winsorised_rim() if robust else None
        self.clipped = 0
        self.overshoot = 0.0
        self.guidance_time, self.paste_time = Stopwatch(), Stopwatch()

    @cached_property
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

    def equations(self, first: int, end: int) -> Iterator[Equations]:
        """f* - a outside Omega, zero in it, and the field's w."""
        height = self.shape[0]
        for low, high, layers in self.bands(first, end):
            with self.guidance_time:
                top, bottom = max(low - 1, 0), min(high + 1, height)
                band = Band(*layers, top, bottom)
                w = self.field.beyond(band) if self.field.beyond is not None else None
                f, base = band.destination, self.field.base(band)
                np.copyto(_pixels(f), _pixels(base), where=self.region[top:bottom])
                f -= base
                if self._rim is not None:
                    rows, cols, differences = self._rim
                    here = slice(*np.searchsorted(rows, (top, bottom)))
                    f[rows[here] - top, cols[here]] = differences[here]
                across, down = (None, None) if w is None else (w.across, w.down)
            yield Equations(low, high, top, f, across, down)

    def paint(self, correct: Correct, share: Share) -> NDArray[Any]:
        """The destination with a + u in Omega, rounded and clipped as its depth asks for."""
        with self.paste_time:
            top = self._placement.top
            bottom = top + len(self.region)
            picture = np.empty(self._picture.shape, self._picture.dtype)
            picture[:top], picture[bottom:] = self._picture[:top], self._picture[bottom:]
            larger = LARGER if self._as_stored else 1
            target, base = tone.Stored.of(picture, (top, self._placement.left)), self._base()
            # 16 bits are rarer: nobody is to wait until it is compiled for them.
            at_once = picture.dtype == np.uint8

            def rows(first: int, end: int) -> tuple[int, float]:
                """How many values were clipped, and how far the furthest left the range."""
                if isinstance(correct, Addition) and target is not None and base is not None and at_once:
                    picture[top + first : top + end] = self._picture[top + first : top + end]
                    return tone.paste_sum(target, base, correct, first, end)
                clipped, overshoot = 0, 0.0
                for low, high, layers in self.bands(first, end, larger):
                    picture[top + low : top + high] = self._picture[top + low : top + high]
                    if not self.region[low:high].any():
                        continue  # between parts that lie far apart
                    working, before, stored = self.guess(Band(*layers, low, high))
                    correct(working, low)
                    values = self.space.to_stored(working, before, stored)
                    rows, region = picture[top + low : top + high], self.region[low:high]
                    left = tone.paste(with_channels(rows), values, region, self._placement.left)
                    clipped, overshoot = clipped + left[0], max(overshoot, left[1])
                return clipped, overshoot

            left = share(rows)
            self.clipped = sum(clipped for clipped, _ in left)
            self.overshoot = max(overshoot for _, overshoot in left)
        return picture

    def paint_at(self, place: NDArray[np.int64], correction: NDArray[np.float64]) -> NDArray[Any]:
        """The same where Omega is a few pixels here and there, none of which is looked at but those."""
        with self.paste_time:
            picture = self._picture.copy()
            window = with_channels(self._placement.on_destination(picture))
            base, width = self._base(), window.shape[1]
            painted = tone.Stored.of(picture, (self._placement.top, self._placement.left))
            if base is not None and painted is not None:
                self.clipped, self.overshoot = tone.paste_at(painted, base, correction, place, width)
                return picture
            self.clipped, self.overshoot = 0, 0.0
            for first in range(0, len(place), TOGETHER):
                here = slice(first, first + TOGETHER)
                row = place[here] // width
                col = place[here] - row * width
                points = Points(self._destination, self._source, row, col)
                working, before, stored = self.guess(points)
                working += correction[here, : self.shape[2]]
                values = self.space.to_stored(working, before, stored)
                pixels = np.empty((1, *values.shape), picture.dtype)
                clipped, overshoot = tone.paste(
                    pixels, values[np.newaxis], np.ones((1, len(row)), np.bool_), 0
                )
                self.clipped, self.overshoot = self.clipped + clipped, max(self.overshoot, overshoot)
                window[row, col] = pixels[0]
        return picture

    def guess(self, band: Band) -> tuple[Values, Values | None, Values | None]:
        """The first guess of f there: a, where nothing is known of the mean of f*.

        And for spaces that must know (`Space.to_stored`), if a is a picture: its working values once more, and its
        stored ones.
        """
        base = self.field.base(band)
        before = stored = None
        if self.field.picture is not None and not isinstance(self.space, AsStored):
            before, stored = base.copy(), band.stored(self.field.picture)
        if self._shift is not None:
            base += self._shift
        return base, before, stored

    def range(self) -> tuple[float, float]:
        """The range of the picture in stored values; wider where known values of a float picture leave it."""
        known = self._destination.stored_at(*self._placement.boundary)
        full = tone.FULL_SCALE[self._picture.dtype.type]
        return min(0.0, float(known.min(initial=0))), max(full, float(known.max(initial=full)))

    def rim(self) -> Rim | None:
        """The boundary's f* - a, where that is all there is to know."""
        if self.field.beyond is not None or not self.small_integers:
            return None
        rows, cols = self._placement.boundary
        return Rim(rows, cols, np.ascontiguousarray(self._differences, np.float32))

    def mismatch(self) -> Mismatch:
        """How f* differs from g, and from a, on the boundary: copies, so that the pictures may change."""
        if self._source is None:
            return NOTHING
        there = self._placement.boundary_on_source()
        if self.small_integers and self.field.picture == "source" and there is self._placement.boundary:
            differences = self._differences
        else:
            differences = self._destination.stored_at(*there) - self._source.stored_at(*there)
        return Mismatch(differences, tone.level(self._picture.dtype), self._differences, self.space.level)

    def _winsorised_rim(self) -> tuple[NDArray[np.intp], NDArray[np.intp], Values] | None:
        """Rows, columns and known values of the boundary's pixels, by rows; None if there are none."""
        rows, cols = self._placement.boundary
        if rows.size == 0:
            return None
        return rows, cols, boundary.winsorised(self._differences, self.space.level)

    @cached_property
    def _differences(self) -> Values:
        """f* - a at the boundary's pixels."""
        base, whole = self._base(), self._destination.whole
        if base is not None and whole is not None:
            return tone.subtract(whole, base, *self._placement.boundary)
        points = Points(self._destination, self._source, *self._placement.boundary)
        return points.destination - self.field.base(points)

    @property
    def _as_stored(self) -> bool:
        """Whether a is f* or g, in the values that are stored."""
        return self.field.picture is not None and isinstance(self.space, AsStored)

    def _base(self) -> tone.Stored | None:
        """The picture that a is, as it is stored; None where a is made of pictures, or of one that is not at hand."""
        if not self._as_stored or self._shift is not None:
            return None
        layer = self._source if self.field.picture == "source" else self._destination
        return None if layer is None else layer.whole

    def _mean_shift(self) -> NDArray[Any]:
        """The mean of f* less that of a, per channel."""
        height, width, channels = self.shape
        total = np.zeros(channels)
        for first, end, layers in self.bands(0, height):
            band = Band(*layers, first, end)
            for sign, picture in ((1, band.destination), (-1, self.field.base(band))):
                total += sign * picture.sum((0, 1), dtype=np.float64)
        return (total / (height * width)).astype(self.space.dtype)

    def bands(self, first: int, end: int, larger: int = 1) -> Iterator[tuple[int, int, Layers]]:
        """First and end row of each band, see `solvers.canvas.bands`, and both pictures: they are nobody else's."""
        _, width, channels = self.shape
        try:
            layers = self._idle.pop()
        except IndexError:  # all in use, by other threads
            layers = self._destination.apart(), None if self._source is None else self._source.apart()
        for low, high in bands(first, end, width * channels, larger):
            yield low, high, layers
        self._idle.append(layers)


def _pixels(values: NDArray[Any]) -> NDArray[np.void]:
    """(n, w, C) as (n, w) whole pixels: copied by a mask of theirs, without a mask for each channel."""
    pixel = np.dtype((np.void, values.shape[2] * values.itemsize))
    whole: NDArray[np.void] = values.view(pixel)[:, :, 0]
    return whole
