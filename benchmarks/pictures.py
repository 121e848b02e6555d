"""The two photographs used everywhere, from scikit-image's wheel, continued by reflection to any size."""

from __future__ import annotations

from typing import Any

import numpy as np

Array = np.ndarray[Any, Any]


def destination(height: int, width: int) -> Array:
    """The astronaut, (height, width, 3) uint8."""
    from skimage import data

    return centred(data.astronaut(), height, width)


def source(height: int, width: int) -> Array:
    """The cat, (height, width, 3) uint8."""
    from skimage import data

    return centred(data.chelsea(), height, width)


def centred(photograph: Array, height: int, width: int) -> Array:
    """The photograph in the middle of a frame, mirrored at its edges as often as it takes (or cut)."""
    rows, cols = (
        _reflected(length, frame) for length, frame in zip(photograph.shape, (height, width), strict=False)
    )
    return np.ascontiguousarray(photograph[rows][:, cols])


def _reflected(length: int, frame: int) -> Array:
    """Indices into 0..length-1 that run to and fro over a frame, the photograph in its middle."""
    at = (np.arange(frame) - (frame - length) // 2) % (2 * length)
    return np.where(at < length, at, 2 * length - 1 - at)
