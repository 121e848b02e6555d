"""Plain copy and paste: what the paper's tools are compared with."""

from __future__ import annotations

from typing import Literal

import numpy as np
from numpy.typing import NDArray

__all__ = ["plain_paste"]


def plain_paste(
    destination: NDArray[np.uint8],
    source: NDArray[np.uint8],
    mask: NDArray[np.bool_],
    *,
    offset: tuple[int, int] = (0, 0),
    mask_on: Literal["source", "destination"] = "source",
) -> NDArray[np.uint8]:
    """Copy the selected pixels of one picture onto another.

    Parameters
    ----------
    destination
        (H, W) or (H, W, 3) uint8.
    source
        (h, w) or (h, w, 3) uint8; a grey one is spread over the channels of a coloured destination.
    mask
        (h, w) bool, or (H, W) if it was drawn on the destination; True = copy.
    offset
        (row, column) of the source's top-left corner on the destination; what hangs over is left out.
    mask_on
        The picture that the mask was drawn on.

    Returns
    -------
    ndarray
        A new picture like the destination.

    Examples
    --------
    >>> sky, bird = np.zeros((2, 3), np.uint8), np.array([[7, 8]], np.uint8)
    >>> plain_paste(sky, bird, bird > 7, offset=(1, 0)).tolist()
    [[0, 0, 0], [0, 8, 0]]
    """
    rows, source_rows = _overlap(offset[0], source.shape[0], destination.shape[0])
    cols, source_cols = _overlap(offset[1], source.shape[1], destination.shape[1])
    chosen = mask[source_rows, source_cols] if mask_on == "source" else mask[rows, cols]
    piece = source[source_rows, source_cols]
    if piece.ndim < destination.ndim:
        piece = piece[..., None]
    if destination.ndim == 3:
        chosen = chosen[..., None]
    result = destination.copy()
    result[rows, cols] = np.where(chosen, piece, result[rows, cols])
    return result


def _overlap(start: int, length: int, limit: int) -> tuple[slice, slice]:
    """The part of an axis that both pictures cover: on the destination, and on the source."""
    first, last = np.clip((start, start + length), 0, limit).tolist()
    return slice(first, last), slice(first - start, last - start)
