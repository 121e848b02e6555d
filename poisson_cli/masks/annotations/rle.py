"""COCO's run lengths: how many pixels in turn are not selected and selected, counted down the columns."""

from __future__ import annotations

from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from poisson_cli.errors import InputError
from poisson_cli.masks.annotations.document import items, mapping, picture_size, shown
from poisson_cli.masks.canvas import Canvas

__all__ = ["decode_counts", "rle_runs"]

_LONGEST: Final = 1 << 23
"""Characters of compressed counts: more than an outline has, and few enough for a second and half a gigabyte."""

_MOST_DIGITS: Final = 7
"""Digits of one number: 35 bits with its sign, enough for any picture, and no sum of them leaves 64 bits."""


def rle_runs(value: Any, canvas: Canvas, what: str) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Read a run-length encoded mask.

    Parameters
    ----------
    value
        The JSON value: ``{"size": [h, w], "counts": [...] or "..."}``.
    canvas
        The picture, which must have that size.
    what
        What it is, for messages.

    Returns
    -------
    starts, ends : ndarray
        (n,) int64 for `poisson_cli.masks.runs.paint`; pixels are numbered down the columns.

    Raises
    ------
    InputError
        If it is no such value, or does not fit the picture.
    """
    rle = mapping(value, what)
    size = items(rle.get("size"), f"the size of {what}")
    if len(size) != 2:
        raise InputError(f"the size of {what} has {len(size)} numbers, not a height and a width")
    canvas.refuse_other_size(f"{what} is for a picture of", picture_size(size[0], size[1], what))
    counts = rle.get("counts")
    pixels = canvas.shape[0] * canvas.shape[1]
    lengths = decode_counts(counts, what) if isinstance(counts, str) else _listed(counts, pixels, what)
    # Each one first: a sum of numbers that are all small enough cannot overflow.
    sound = lengths.size == 0 or (lengths.min() >= 0 and lengths.max() <= pixels)
    if not sound or lengths.sum() != pixels:
        raise InputError(f"the counts of {what} do not add up to the {pixels:,} pixels of its size")
    borders = np.cumsum(lengths)
    ends = borders[1::2]
    return borders[0::2][: ends.size], ends


def decode_counts(text: str, what: str) -> NDArray[np.int64]:
    """Decode the compressed form of counts.

    Every number is written in digits of five bits, least first, as characters from ``"0"`` (48) on; 32 is added to all
    digits but the last, and bit 16 of the last is the sign. From the fourth number on, what is written is the
    difference to the number two before.

    Parameters
    ----------
    text
        The compressed counts.
    what
        What they belong to, for messages.

    Returns
    -------
    ndarray
        (n,) int64; whether the numbers make sense is not checked.

    Raises
    ------
    InputError
        If the text is not of this form.

    Examples
    --------
    >>> decode_counts("52203", "an example").tolist()
    [5, 2, 2, 2, 5]
    """
    if len(text) > _LONGEST:
        raise InputError(f"the counts of {what} are more than {_LONGEST:,} characters; simplify the mask")
    digits = np.frombuffer(text.encode("ascii", "replace"), np.uint8).astype(np.int16) - 48
    if digits.size == 0:
        return np.zeros(0, np.int64)
    last = np.flatnonzero(digits < 32)  # the last digit of each number
    first = np.concatenate(([0], last[:-1] + 1))
    if (
        not text.isascii()
        or digits.min() < 0
        or digits.max() > 63
        or last.size == 0
        or last[-1] != digits.size - 1
    ):
        raise InputError(f"the counts of {what} are not compressed as COCO does it")
    length = last + 1 - first
    if length.max() > _MOST_DIGITS:
        raise InputError(f"the counts of {what} have a number that is larger than any picture")
    shift = 5 * (np.arange(digits.size) - np.repeat(first, length))
    numbers: NDArray[np.int64] = np.add.reduceat((digits & 31).astype(np.int64) << shift, first)
    numbers -= ((digits[last] & 16) != 0) * (np.int64(1) << 5 * length)
    numbers[1::2] = np.cumsum(numbers[1::2])
    numbers[2::2] = np.cumsum(numbers[2::2])
    return numbers


def _listed(counts: Any, pixels: int, what: str) -> NDArray[np.int64]:
    """The plain form: a list of whole numbers."""
    counts = items(counts, f"the counts of {what}")
    for count in counts:
        if type(count) is not int or not 0 <= count <= pixels:
            raise InputError(f"the counts of {what} have {shown(count)} where a number of pixels should be")
    return np.array(counts, np.int64)
