"""Mask pictures: how strongly each of their pixels is selected."""

from __future__ import annotations

import re
from typing import Final

import numpy as np
from numpy.typing import NDArray

from poisson_cli.errors import InputError
from poisson_cli.images import Picture, decode, decode_indices

__all__ = ["NEAR", "count_near", "decode_strength", "strength"]

NEAR: Final = 16
"""Levels, on either side of the threshold, that a lossy file may have moved a pixel by, or soft edges are made of."""

_CHANNELS: Final = {"red": 0, "green": 1, "blue": 2}
_INDEX: Final = re.compile(r"index=([0-9]{1,3})")


def strength(picture: Picture) -> NDArray[np.uint8]:
    """Read a picture as a selection; a pixel is selected where the value is at least the threshold.

    Three kinds of mask are in use, and what the file holds tells them apart:

    1. Transparent in places: an object cut out, or a selection painted on an empty layer. The opacity counts,
       whatever the colour.
    2. A palette with a colour in use: a map of labels. Every label but black, the customary colour of "nothing",
       counts in full: the colours of labels are names, not brightnesses.
    3. Any other: the largest channel counts. As long as the threshold is above the noise of JPEG, a lossy mask
       selects what its author drew.

    Parameters
    ----------
    picture
        Any picture of shape (H, W).

    Returns
    -------
    ndarray
        (H, W) uint8, 0 = not selected by any threshold, 255 = selected by every threshold.

    Examples
    --------
    >>> strength(Picture("mask.png", np.array([[[0, 0, 0], [7, 90, 30]]], np.uint8))).tolist()
    [[0, 90]]
    """
    if picture.alpha is not None and picture.alpha.min() != picture.alpha.max():
        return picture.alpha
    pixels = picture.pixels
    if pixels.ndim == 2:
        return pixels
    brightest: NDArray[np.uint8] = pixels.max(axis=2)
    if picture.palette and (brightest != pixels.min(axis=2)).any():
        return np.where(brightest > 0, np.uint8(255), np.uint8(0))
    return brightest


def decode_strength(data: bytes, name: str, part: str | None) -> NDArray[np.uint8]:
    """Decode a picture as a selection.

    Parameters
    ----------
    data
        The whole file.
    name
        What to call it in messages.
    part
        What of it counts: ``alpha``, ``red``, ``green``, ``blue``, or ``index=N`` for the pixels with entry N of the
        palette, or of value N in a grey picture. None leaves it to `strength`.

    Returns
    -------
    ndarray
        (H, W) uint8, as `strength`.

    Raises
    ------
    InputError
        If it cannot be decoded, or has no such part.
    """
    index = _INDEX.fullmatch(part or "")
    if index is not None and int(index[1]) <= 255:
        chosen = decode_indices(data, name) == int(index[1])
        return np.where(chosen, np.uint8(255), np.uint8(0))
    picture = decode(data, name).in_8_bits()
    if part is None:
        return strength(picture)
    if part == "alpha":
        if picture.alpha is None:
            raise InputError(f"{name}: the picture is {picture.layout} and has no alpha channel")
        return picture.alpha
    if part in _CHANNELS:
        if picture.pixels.ndim == 2:
            raise InputError(f"{name}: the picture is {picture.layout}; it has no colours to choose from")
        return np.ascontiguousarray(picture.pixels[..., _CHANNELS[part]])
    raise InputError(
        f"{name}: a picture has no part called {part!r}; choose one of alpha, red, green, blue, index=0 to index=255"
    )


def count_near(values: NDArray[np.uint8], threshold: int) -> int:
    """Count the pixels that a threshold decides narrowly, where it cuts through a slope of grey.

    Parameters
    ----------
    values
        (H, W) uint8, from `strength`.
    threshold
        Value from which a pixel is selected.

    Returns
    -------
    int
        Pixels less than `NEAR` below the threshold or above it; 0 unless there are some on both sides, because in a
        mask of a few clean values the threshold decides nothing narrowly.

    Examples
    --------
    >>> count_near(np.array([[0, 120, 127, 128, 255]], np.uint8), 128)
    3
    """
    below = np.count_nonzero((values >= max(threshold - NEAR, 1)) & (values < threshold))
    above = np.count_nonzero((values >= threshold) & (values < min(threshold + NEAR, 255)))
    return int(below + above) if below and above else 0
