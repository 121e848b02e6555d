"""The pictures under the window, as working values, a few rows at a time."""

from collections.abc import Callable
from copy import copy
from functools import cached_property
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from poisson_cli.editing import tone
from poisson_cli.editing.placement import Placement
from poisson_cli.editing.spaces import AsStored, Space
from poisson_cli.errors import InputError
from solvers.canvas import Values

# Another look of a picture: stored values as floats, (..., C) -> (..., C), or (..., 1) for all channels alike.
Look = Callable[[Values], Values]


class Layer:
    """The part of a picture that lies under the window; holds a view, no copy.

    Parameters
    ----------
    stored : (h, w, C) array
        Of a depth that `tone` knows.  Where the picture ends before the window does, fewer rows and columns.
    channels : int
        How many stored values a pixel has: a picture of one channel is spread over them.
    padding : ((north, south), (west, east))
        Rows and columns of the window beyond the picture: there it continues with the value at its edge.
    look : callable, optional
        What to show of the picture instead of its stored values.
    space : Space, optional
        The space of the working values; the values as stored if none is given.
    whole : Stored, optional
        The whole picture, where what is shown of it are its own values.
    """

    def __init__(
        self,
        stored: NDArray[Any],
        channels: int,
        padding: tuple[tuple[int, int], tuple[int, int]] = ((0, 0), (0, 0)),
        *,
        look: Look | None = None,
        space: Space | None = None,
        whole: tone.Stored | None = None,
    ) -> None:
        self.space = space or AsStored(stored.dtype)
        self.channels = self.space.channels(channels)
        self.look = look
        self.whole = whole
        self._picture = stored
        self._stored_channels = channels
        self._padding = padding
        self._stored_dtype = tone.working_dtype(stored.dtype)
        self._memory = np.empty(0, self._stored_dtype)

    @classmethod
    def of_destination(
        cls, destination: NDArray[Any], placement: Placement, space: Space | None = None
    ) -> "Layer":
        """The destination f*, checked: its values must be numbers, and have a place in the space."""
        stored = _with_channels(placement.on_destination(destination))
        tone.check_values("destination", stored)
        if space is not None:
            space.check("destination", stored.shape[2])
        whole = tone.Stored.of(destination, (placement.top, placement.left))
        return cls(stored, stored.shape[2], space=space, whole=whole)

    @classmethod
    def of_source(
        cls,
        source: NDArray[Any],
        placement: Placement,
        channels: int | None,
        *,
        look: Look | None = None,
        space: Space | None = None,
    ) -> "Layer":
        """The source g, checked; `channels` are the destination's, None if it is (H, W)."""
        rows, cols, padding = placement.source_window()
        stored = _with_channels(source[rows, cols])
        tone.check_values("source", stored)
        own = stored.shape[2]
        if look is not None:
            own = look(np.zeros((1, own), np.float32)).shape[-1]
        if channels is None and own != 1:
            raise InputError(
                f"the source has {own} channels but the destination is grey: convert the source, or import "
                "its luminance only (monochrome)"
            )
        if own not in (1, channels or 1):
            raise InputError(
                f"the source has {own} channels but the destination has {channels}: convert one of them"
            )
        as_it_is = look is None and own == (channels or 1) and not any(padding[0] + padding[1])
        whole = tone.Stored.of(source, (rows.start, cols.start)) if as_it_is else None
        return cls(stored, channels or 1, padding, look=look, space=space, whole=whole)

    def apart(self) -> "Layer":
        """The same layer with memory of its own, for another thread."""
        layer = copy(self)
        layer._memory = np.empty(0, self._stored_dtype)
        return layer

    def rows(self, first: int, end: int) -> Values:
        """Working values of rows first ... end of the window, (end - first, w, channels).

        Valid until the next call, and to write in.
        """
        return self.space.to_working(self.stored_rows(first, end))

    def stored_rows(self, first: int, end: int) -> Values:
        """Stored values of these rows, as floats, (end - first, w, C); valid until the next call."""
        part = self._shown(self._part(first, end))
        size = part.shape[0] * part.shape[1] * self._stored_channels
        if self._memory.size < size:
            self._memory = np.empty(size, self._stored_dtype)
        values = self._memory[:size].reshape(*part.shape[:2], self._stored_channels)
        np.copyto(values, part)
        return values

    def at(self, row: NDArray[np.intp], col: NDArray[np.intp]) -> Values:
        """Working values of single pixels of the window, (n, channels)."""
        return self.space.to_working(self.stored_at(row, col))

    def stored_at(self, row: NDArray[np.intp], col: NDArray[np.intp]) -> Values:
        """Stored values of single pixels of the window, as floats, (n, C)."""
        (north, _), (west, _) = self._padding
        height, width = self._picture.shape[:2]
        if any(self._padding[0] + self._padding[1]):
            row, col = np.clip(row - north, 0, height - 1), np.clip(col - west, 0, width - 1)
        shown = self._shown(_at(self._picture, row, col))
        if shown.shape[1] != self._stored_channels:
            shown = np.broadcast_to(shown, (len(shown), self._stored_channels))
        values: Values = shown.astype(self._stored_dtype)
        return values

    def _part(self, first: int, end: int) -> NDArray[Any]:
        """The picture in these rows of the window; beyond the picture the values at its edge."""
        (north, south), (west, east) = self._padding
        if not (north or south or west or east):
            return self._picture[first:end]
        height, width = self._picture.shape[:2]
        rows = np.clip(np.arange(first, end) - north, 0, height - 1)
        cols = np.clip(np.arange(west + width + east) - west, 0, width - 1)
        continued: NDArray[Any] = self._picture[rows[:, np.newaxis], cols]
        return continued

    def _shown(self, part: NDArray[Any]) -> NDArray[Any]:
        return part if self.look is None else self.look(part.astype(self._stored_dtype))


class Band:
    """Both pictures in rows first ... end of the window, each made when it is asked for."""

    def __init__(self, destination: Layer, source: Layer | None, first: int, end: int) -> None:
        self._layers = destination, source
        self.rows = first, end

    @cached_property
    def destination(self) -> Values:
        """f*, (n, w, channels)."""
        return self._of(self._layers[0])

    @cached_property
    def source(self) -> Values:
        """g, (n, w, channels)."""
        assert self._layers[1] is not None, "a field that needs a source was given none"
        return self._of(self._layers[1])

    def stored(self, name: Literal["destination", "source"]) -> Values:
        """Stored values of one of them, as floats."""
        layer = self._layers[name == "source"]
        assert layer is not None, "a field that needs a source was given none"
        return self._stored_of(layer)

    def _of(self, layer: Layer) -> Values:
        return layer.rows(*self.rows)

    def _stored_of(self, layer: Layer) -> Values:
        return layer.stored_rows(*self.rows)


class Points(Band):
    """Both pictures in single pixels of the window, as (n, channels) values."""

    def __init__(
        self, destination: Layer, source: Layer | None, row: NDArray[np.intp], col: NDArray[np.intp]
    ) -> None:
        self._layers = destination, source
        self._where = row, col

    def _of(self, layer: Layer) -> Values:
        return layer.at(*self._where)

    def _stored_of(self, layer: Layer) -> Values:
        return layer.stored_at(*self._where)


def _at(picture: NDArray[Any], row: NDArray[np.intp], col: NDArray[np.intp]) -> NDArray[Any]:
    """(n, C) values of single pixels of (H, W, C); as whole pixels, in half the time, where they lie in one piece."""
    channels, size = picture.shape[2], picture.itemsize
    if picture.strides[2] != size:
        return picture[row, col]
    whole = picture.view(np.dtype((np.void, channels * size)))[:, :, 0]
    return whole[row, col].view(picture.dtype).reshape(-1, channels)


def _with_channels(picture: NDArray[Any]) -> NDArray[Any]:
    return picture if picture.ndim == 3 else picture[:, :, np.newaxis]
