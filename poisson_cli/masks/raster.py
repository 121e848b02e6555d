"""Mask pictures: how strongly each of their pixels is selected."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from poisson_cli.images import Picture

__all__ = ["strength"]


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
