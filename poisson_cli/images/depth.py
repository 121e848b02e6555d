"""Depths of pictures, and the way from one to another.

Full scale is 255, 65535 and 1.0. A conversion maps full scale to full scale, so 8 bits become 16, or floats, and come
back as they were.
"""

from __future__ import annotations

from typing import Any, Final, Literal, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

__all__ = ["DTYPES", "Conversion", "Depth", "Samples", "convert", "depth_of", "full_scale", "in_words"]

Depth: TypeAlias = Literal["8", "16", "float"]
Samples: TypeAlias = NDArray[np.uint8] | NDArray[np.uint16] | NDArray[np.float32]

DTYPES: Final[dict[Depth, np.dtype[Any]]] = {
    "8": np.dtype(np.uint8),
    "16": np.dtype(np.uint16),
    "float": np.dtype(np.float32),
}
_BAND: Final = 1 << 20
"""Values that are converted at a time, so that the floats in between need little memory."""


class Conversion(NamedTuple):
    """Converted values, and what could not be kept.

    Parameters
    ----------
    values
        In the new depth.
    clipped
        Floats below 0 or above 1 that became the nearest integer there is.
    undefined
        NaNs that became 0.
    """

    values: NDArray[Any]
    clipped: int = 0
    undefined: int = 0


def depth_of(values: NDArray[Any]) -> Depth:
    """The depth of an array; KeyError if it has none of ours."""
    return {dtype: depth for depth, dtype in DTYPES.items()}[values.dtype]


def full_scale(depth: Depth) -> float:
    """White, or opaque, in stored units."""
    return 1.0 if depth == "float" else float(np.iinfo(DTYPES[depth]).max)


def in_words(depth: Depth) -> str:
    """As in ``16 bits per channel``."""
    return "floating point" if depth == "float" else f"{depth} bits per channel"


def convert(values: NDArray[Any], depth: Depth) -> Conversion:
    """Bring values to another depth.

    Parameters
    ----------
    values
        Any shape; uint8, uint16 or float32. Not modified.
    depth
        The depth to have. Values are rounded to the nearest one there is.

    Returns
    -------
    Conversion
        The array itself where it has that depth already.

    Examples
    --------
    >>> convert(np.array([0, 128, 255], np.uint8), "16").values.tolist()
    [0, 32896, 65535]
    >>> convert(np.array([-0.5, 0.5, np.nan], np.float32), "8")
    Conversion(values=array([  0, 128,   0], dtype=uint8), clipped=1, undefined=1)
    """
    before = depth_of(values)
    if before == depth:
        return Conversion(values)
    converted = np.empty(values.shape, DTYPES[depth])
    if before != "float" and depth != "float":
        if depth == "16":
            np.multiply(values, 257, out=converted, dtype=np.uint16)
        else:  # 65535 = 255 * 257, and no value lies halfway between two multiples of 257
            _in_bands(values, converted, lambda band: (band.astype(np.uint32) + 128) // 257)
        return Conversion(converted)
    if depth == "float":
        np.divide(values, np.float32(full_scale(before)), out=converted)
        return Conversion(converted)

    lost = [0, 0]
    full = np.float32(full_scale(depth))

    def rounded(band: NDArray[Any]) -> NDArray[Any]:
        undefined = np.isnan(band)
        lost[0] += int(np.count_nonzero((band < 0) | (band > 1)))
        lost[1] += int(np.count_nonzero(undefined))
        band = np.where(undefined, np.float32(0), band)
        whole: NDArray[Any] = np.rint(np.clip(band, 0, 1) * full)
        return whole

    _in_bands(values, converted, rounded)
    return Conversion(converted, *lost)


def _in_bands(values: NDArray[Any], out: NDArray[Any], function: Any) -> None:
    """Fill an array a few values at a time."""
    flat, flat_out = values.reshape(-1), out.reshape(-1)
    for start in range(0, flat.size, _BAND):
        flat_out[start : start + _BAND] = function(flat[start : start + _BAND])
