"""The pictures under the window, as working floats, a few rows at a time."""

from copy import copy
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from poisson_cli.editing import tone
from poisson_cli.editing.placement import Placement
from poisson_cli.errors import InputError
from solvers.canvas import Values


class Layer:
    """The part of a picture that lies under the window; holds a view, no copy.

    Parameters
    ----------
    stored : (h, w, C) array
        Of a depth that `tone` knows.  Where the picture ends before the window does, fewer rows and columns.
    channels : int
        How many the layer shows: a picture of one channel is spread over them.
    padding : ((north, south), (west, east))
        Rows and columns of the window beyond the picture: there it continues with the value at its edge.
    monochrome : bool
        Show luminance only.
    """

    def __init__(
        self,
        stored: NDArray[Any],
        channels: int,
        padding: tuple[tuple[int, int], tuple[int, int]] = ((0, 0), (0, 0)),
        *,
        monochrome: bool = False,
    ) -> None:
        self.stored = stored
        self.channels = channels
        self.padding = padding
        self.monochrome = monochrome
        self.dtype = tone.working_dtype(stored.dtype)
        self._memory = np.empty(0, self.dtype)

    @classmethod
    def of_destination(cls, destination: NDArray[Any], placement: Placement) -> "Layer":
        """The destination f*, checked for values that are no numbers."""
        stored = _with_channels(placement.on_destination(destination))
        tone.check_values("destination", stored)
        return cls(stored, stored.shape[2])

    @classmethod
    def of_source(
        cls, source: NDArray[Any], placement: Placement, channels: int | None, *, monochrome: bool = False
    ) -> "Layer":
        """The source g, checked; `channels` are the destination's, None if it is (H, W)."""
        rows, cols, padding = placement.source_window()
        stored = _with_channels(source[rows, cols])
        tone.check_values("source", stored)
        own = stored.shape[2]
        if monochrome:
            tone.check_luminance(own)
        elif channels is None and own != 1:
            raise InputError(
                f"the source has {own} channels but the destination is grey: convert the source, or import "
                "its luminance only (monochrome)"
            )
        elif own not in (1, channels):
            raise InputError(
                f"the source has {own} channels but the destination has {channels}: convert one of them"
            )
        return cls(stored, channels or 1, padding, monochrome=monochrome)

    def apart(self) -> "Layer":
        """The same layer with memory of its own, for another thread."""
        layer = copy(self)
        layer._memory = np.empty(0, self.dtype)
        return layer

    def rows(self, first: int, end: int) -> Values:
        """Rows first ... end of the window, (end - first, w, channels): valid until the next call, and to write in."""
        part = self._shown(self._part(first, end))
        size = part.shape[0] * part.shape[1] * self.channels
        if self._memory.size < size:
            self._memory = np.empty(size, self.dtype)
        values = self._memory[:size].reshape(*part.shape[:2], self.channels)
        np.copyto(values, part)
        return values

    def at(self, row: NDArray[np.intp], col: NDArray[np.intp]) -> Values:
        """Pixels of the window that lie on the picture: (n, channels), or (n, 1) for one to be spread."""
        (north, _), (west, _) = self.padding
        shown: NDArray[Any] = self._shown(self.stored[row - north, col - west][np.newaxis])[0]
        return shown

    def _part(self, first: int, end: int) -> NDArray[Any]:
        """Stored values of these rows of the window; beyond the picture those at its edge."""
        (north, south), (west, east) = self.padding
        if not (north or south or west or east):
            return self.stored[first:end]
        height, width = self.stored.shape[:2]
        rows = np.clip(np.arange(first, end) - north, 0, height - 1)
        cols = np.clip(np.arange(west + width + east) - west, 0, width - 1)
        continued: NDArray[Any] = self.stored[rows[:, np.newaxis], cols]
        return continued

    def _shown(self, stored: NDArray[Any]) -> NDArray[Any]:
        """Stored values, or their luminance; (n, w, channels or 1)."""
        if not self.monochrome:
            return stored
        working: Values = stored.astype(self.dtype)
        grey: NDArray[Any] = tone.luminance(working)[:, :, np.newaxis]
        return grey


class Band:
    """Both pictures in rows first ... end of the window, each made when it is asked for."""

    def __init__(self, destination: Layer, source: Layer | None, first: int, end: int) -> None:
        self._layers = destination, source
        self._rows = first, end

    @cached_property
    def destination(self) -> Values:
        """f*, (n, w, channels)."""
        return self._layers[0].rows(*self._rows)

    @cached_property
    def source(self) -> Values:
        """g, (n, w, channels)."""
        assert self._layers[1] is not None, "a field that needs a source was given none"
        return self._layers[1].rows(*self._rows)


def _with_channels(picture: NDArray[Any]) -> NDArray[Any]:
    return picture if picture.ndim == 3 else picture[:, :, np.newaxis]
