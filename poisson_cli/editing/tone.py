"""Stored values and working floats; rounding and clipping happen here and nowhere else.

Working values keep the stored scale: 0..255 for 8 bit, 0..65535 for 16 bit, 0..1 for floats.  All integers of these
ranges are exact in float32, so a value that an edit leaves alone comes back as the same integer.
"""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from poisson_cli.errors import InputError
from solvers.canvas import Values
from solvers.correction import Addition
from solvers.kernels.pictures import round_at, round_into, subtract_pictures
from solvers.problem import LARGEST_VALUE

FULL_SCALE: dict[type[np.generic], float] = {
    np.uint8: 255.0,
    np.uint16: 65535.0,
    np.float32: 1.0,
    np.float64: 1.0,
}


class Stored(NamedTuple):
    """A picture of integers that lies in one piece, as kernels want it, and where a window begins on it.

    Attributes
    ----------
    pixels : (H, W, C) uint8 or uint16, C-contiguous
    corner : (row, column)
    """

    pixels: NDArray[Any]
    corner: tuple[int, int]

    @classmethod
    def of(cls, picture: NDArray[Any], corner: tuple[int, int]) -> "Stored | None":
        """None for floats, and for pictures that do not lie in one piece."""
        if picture.dtype.kind != "u" or not picture.flags.c_contiguous:
            return None
        return cls(picture if picture.ndim == 3 else picture[:, :, np.newaxis], corner)


def subtract(one: Stored, other: Stored, rows: NDArray[np.intp], cols: NDArray[np.intp]) -> Values:
    """one - other, (n, C) float32, at single pixels of the window."""
    differences = np.empty((len(rows), one.pixels.shape[2]), np.float32)
    subtract_pictures(
        differences, one.pixels, other.pixels, rows, cols, np.array([*one.corner, *other.corner])
    )
    return differences


def check_picture(name: str, picture: Any) -> NDArray[Any]:
    """`picture` as an array that can be edited: (H, W) or (H, W, C) of a known depth, with at least one value.

    Its values come in the machine's byte order, whatever theirs is.

    Raises
    ------
    InputError
        Naming the picture and what is wrong with it.
    """
    array = np.asarray(picture)
    if array.dtype.type not in FULL_SCALE:
        known = ", ".join(t.__name__ for t in FULL_SCALE)
        raise InputError(f"the {name} has values of type {array.dtype}; convert it to one of {known}")
    if array.ndim not in (2, 3) or array.size == 0:
        raise InputError(
            f"the {name} has shape {array.shape}; a picture is (H, W) or (H, W, C) and not empty"
        )
    return array.astype(array.dtype.newbyteorder("="), copy=False)


def level(dtype: np.dtype[Any]) -> float:
    """The size of one level, 1/255 of full scale, in stored units."""
    return FULL_SCALE[dtype.type] / 255.0


def working_dtype(dtype: np.dtype[Any]) -> np.dtype[Any]:
    """The floats to compute with: float64 for float64, float32 for all others."""
    return np.dtype(np.float64 if dtype == np.float64 else np.float32)


def check_values(name: str, stored: NDArray[Any]) -> None:
    """InputError if a value is NaN, infinite, or too large to compute with."""
    if stored.dtype.kind == "f" and stored.size:
        if not (-LARGEST_VALUE < stored.min() <= stored.max() < LARGEST_VALUE):
            raise InputError(
                f"the {name} has NaN, infinite or huge values in or beside the selection; replace them first"
            )


def to_storage(working: Values, dtype: np.dtype[Any]) -> NDArray[Any]:
    """Working floats in a picture's depth: integers are rounded half to even and clipped, floats are kept.

    `working` is written into.
    """
    if dtype.kind == "f":
        return working.astype(dtype, copy=False)
    np.rint(working, out=working)
    return np.clip(working, 0, FULL_SCALE[dtype.type], out=working).astype(dtype)


def paste(picture: NDArray[Any], values: Values, region: NDArray[np.bool_], left: int) -> tuple[int, float]:
    """Stored values as floats into the region of a picture, as `to_storage` makes them; all in one pass.

    Parameters
    ----------
    picture : (n, W, C) array
        Written into where `region` is True, from column `left` on.
    values : (n, w, C) float
    region : (n, w) bool

    Returns
    -------
    int, float
        How many values of the region were clipped, and how far the furthest left the range, in levels.
    """
    largest, dtype = FULL_SCALE[picture.dtype.type], picture.dtype
    if dtype.kind == "u":
        marks = np.empty(values.shape[1] * values.shape[2], np.uint8)
        clipped, beyond = round_into(
            picture, marks, np.ascontiguousarray(values), region, left, values.dtype.type(largest)
        )
        return int(clipped), float(beyond) / level(dtype)
    np.copyto(picture[:, left : left + values.shape[1]], values, where=region[:, :, np.newaxis])
    overshoot = excess(values[region], dtype) if excess(values, dtype) > 0 else 0.0
    return 0, overshoot / level(dtype)


def paste_sum(picture: Stored, base: Stored, correction: Addition, first: int, end: int) -> tuple[int, float]:
    """The same for base + correction, for pictures of integers; rows first ... end of the window, `first` is even."""
    corners, largest = np.array([*picture.corner, *base.corner]), FULL_SCALE[picture.pixels.dtype.type]
    clipped, beyond = correction.round_into(picture.pixels, base.pixels, corners, largest, first, end)
    return int(clipped), beyond / level(picture.pixels.dtype)


def paste_at(
    picture: Stored, base: Stored, correction: NDArray[np.float64], place: NDArray[np.int64], width: int
) -> tuple[int, float]:
    """The same for base + correction, (n, C), at places row * width + column, ascending, of pictures of integers."""
    largest = FULL_SCALE[picture.pixels.dtype.type]
    corners = np.array([*picture.corner, *base.corner])
    clipped, beyond = round_at(
        picture.pixels, base.pixels, correction, place, width, corners, np.float32(largest)
    )
    return int(clipped), float(beyond) / level(picture.pixels.dtype)


def excess(working: Values, dtype: np.dtype[Any]) -> float:
    """How far the values leave the range of a depth, in stored units; 0 if none does, or if there are none."""
    if working.size == 0:
        return 0.0
    return max(0.0, -float(working.min()), float(working.max()) - FULL_SCALE[dtype.type])


def count_clipped(working: Values, dtype: np.dtype[Any]) -> int:
    """How many values `to_storage` would clip; none for floats."""
    if dtype.kind == "f":
        return 0
    return int(np.count_nonzero(working < -0.5) + np.count_nonzero(working > FULL_SCALE[dtype.type] + 0.5))


def check_luminance(name: str, channels: int) -> None:
    """InputError if pictures of so many channels have no luminance."""
    if channels not in (1, 3):
        raise InputError(f"luminance needs red, green and blue, but the {name} has {channels} channels")


def check_colours(name: str, channels: int) -> None:
    """InputError unless a picture has the three channels that colours need."""
    if channels != 3:
        raise InputError(
            f"colours are made of red, green and blue, but the {name} has {channels} channel{'s'[: channels - 1]}"
        )
