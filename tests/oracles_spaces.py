"""Colour spaces from their standards, for the oracles: numpy only, float64, nothing of ours.

Each space is a pair of functions between stored values, (..., C) with full scale 1, and the values that the
equations are solved in.  Values out of range go on as the formulas do, so that nothing is clipped on the way.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

Array = np.ndarray

# IEC 61966-2-1: linear sRGB to CIE XYZ (its rows sum to the white point D65).
XYZ_OF_LINEAR = np.array(
    [
        [0.4124, 0.3576, 0.1805],
        [0.2126, 0.7152, 0.0722],
        [0.0193, 0.1192, 0.9505],
    ]
)
WHITE = XYZ_OF_LINEAR.sum(axis=1)

# CIE 15: where the cube root gives way to a straight line.
DELTA = 6 / 29


class Space(NamedTuple):
    """There and back."""

    work: Callable[[Array], Array]
    store: Callable[[Array], Array]


def linear_of_srgb(stored: Array) -> Array:
    """Light, from the values that sRGB stores: IEC 61966-2-1, odd where a value is negative."""
    size = np.abs(stored)
    return np.sign(stored) * np.where(size <= 0.04045, size / 12.92, ((size + 0.055) / 1.055) ** 2.4)


def srgb_of_linear(light: Array) -> Array:
    """The inverse of `linear_of_srgb`."""
    size = np.abs(light)
    return np.sign(light) * np.where(size <= 0.04045 / 12.92, 12.92 * size, 1.055 * size ** (1 / 2.4) - 0.055)


def lab_of_srgb(stored: Array) -> Array:
    """CIE-Lab under D65: L from 0 to 100."""
    t = linear_of_srgb(stored) @ (XYZ_OF_LINEAR / WHITE[:, None]).T
    x, y, z = np.moveaxis(np.where(t > DELTA**3, np.cbrt(t), t / (3 * DELTA**2) + 4 / 29), -1, 0)
    return np.stack([116 * y - 16, 500 * (x - y), 200 * (y - z)], axis=-1)


def srgb_of_lab(lab: Array) -> Array:
    """The inverse of `lab_of_srgb`; colours that sRGB cannot show have values beyond 0 and 1."""
    y = (lab[..., 0] + 16) / 116
    f = np.stack([y + lab[..., 1] / 500, y, y - lab[..., 2] / 200], axis=-1)
    t = np.where(f > DELTA, f**3, 3 * DELTA**2 * (f - 4 / 29))
    return srgb_of_linear(t @ np.linalg.inv(XYZ_OF_LINEAR / WHITE[:, None]).T)


SPACES = {
    "rgb": Space(lambda stored: stored, lambda work: work),
    "linear": Space(linear_of_srgb, srgb_of_linear),
    "lab": Space(lab_of_srgb, srgb_of_lab),
}
