"""Copy and paste, with a hard or a soft outline: what the paper's tools are compared with."""

from __future__ import annotations

from typing import Literal

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageFilter

__all__ = ["plain_paste"]


def plain_paste(
    destination: NDArray[np.uint8],
    source: NDArray[np.uint8],
    mask: NDArray[np.bool_],
    *,
    offset: tuple[int, int] = (0, 0),
    mask_on: Literal["source", "destination"] = "source",
    feather: float = 0,
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
    feather
        Standard deviation in pixels of a Gaussian blur of the mask, which then says how much of each picture is taken
        (alpha blending). 0 leaves it as it is.

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
    share = _softened(mask, feather)
    share = share[source_rows, source_cols] if mask_on == "source" else share[rows, cols]
    piece = source[source_rows, source_cols]
    if piece.ndim < destination.ndim:
        piece = piece[..., None]
    if destination.ndim == 3:
        share = share[..., None]
    result = destination.copy()
    below = result[rows, cols]
    result[rows, cols] = np.rint(below + share * (piece - below.astype(np.float64))).astype(np.uint8)
    return result


def _softened(mask: NDArray[np.bool_], feather: float) -> NDArray[np.float64]:
    """The share of the source in each pixel, 0 to 1."""
    if not feather:
        return mask.astype(np.float64)
    image = Image.fromarray(np.where(mask, np.uint8(255), np.uint8(0)))
    return np.asarray(image.filter(ImageFilter.GaussianBlur(feather))) / 255


def _overlap(start: int, length: int, limit: int) -> tuple[slice, slice]:
    """The part of an axis that both pictures cover: on the destination, and on the source."""
    first, last = np.clip((start, start + length), 0, limit).tolist()
    return slice(first, last), slice(first - start, last - start)
