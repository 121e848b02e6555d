"""What it means for an answer to agree with the oracle, said once."""

import math

import numpy as np

from tests import oracles

LARGEST_ERROR = 0.01
"""Levels: how far any value may be from the exact one before rounding (issue: "It must show", 1)."""

SHARE_THAT_MAY_DIFFER = 1e-4
"""Of the rounded values, at most this share may differ from the exact answer's (ties aside)."""

EXACT_TIE = 1e-7
"""Closer to a half than this, a value counts as a tie: the oracle itself cannot say where it belongs."""


def assert_untouched(image: np.ndarray, destination: np.ndarray, region: np.ndarray) -> None:
    """Same dtype and shape, and outside the region the same bits."""
    assert image.dtype == destination.dtype
    assert image.shape == destination.shape
    assert image[~region].tobytes() == destination[~region].tobytes()


def count_different(image: np.ndarray, exact: np.ndarray, region: np.ndarray) -> int:
    """How many integer values inside the region are not the exact ones rounded; exact ties do not count."""
    different = image != oracles.stored(exact, image.dtype)
    different &= oracles.distance_to_tie(exact, image.dtype) > EXACT_TIE
    return int(different[region].sum())


def assert_rounded_right(
    image: np.ndarray, destination: np.ndarray, exact: np.ndarray, region: np.ndarray
) -> None:
    """An integer picture is the exact one rounded, but for values that lie within .01 level of a tie.

    Of those a share of `SHARE_THAT_MAY_DIFFER` may have gone the other way: one value in a small picture.
    """
    assert_untouched(image, destination, region)
    scale = oracles.full_scale(image.dtype)
    off = np.abs(image.astype(np.float64) - np.clip(exact, 0, scale))[region]
    assert off.max() <= 0.5 + LARGEST_ERROR * scale / 255
    assert count_different(image, exact, region) <= math.ceil(SHARE_THAT_MAY_DIFFER * off.size)


def largest_error(image: np.ndarray, exact: np.ndarray, region: np.ndarray, level: float) -> float:
    """Largest error inside the region, in levels, of values that were not rounded."""
    return float(np.abs(image.astype(np.float64) - exact)[region].max()) / level
