"""The multiscale attenuation of Fattal et al. 2002: large gradients of any size made smaller."""

from collections.abc import Iterator
from typing import Any

import numpy as np

from solvers.canvas import Values

# The shorter side of the coarsest picture is about this long.
SMALLEST = 32
# Norms below this share of a (see `attenuation_map`) count as that: what is weaker is noise, not to be made stronger.
LEAST_NORM = 0.1


def attenuation_map(logs: Values, alpha: float, beta: float) -> Values:
    """The factor for the gradient in each pixel: the product over all scales of (a / |grad|)^beta.

    Parameters
    ----------
    logs : (H, W) float
        Log luminance.
    alpha : float
        a is alpha times the mean gradient norm of its scale.
    beta : float
        The exponent, as in eq. (16); Fattal et al. call the exponent of |grad| / a, less 1, minus that.
    """
    factors: Any = None
    for level, picture in reversed(list(enumerate(_pyramid(logs)))):
        own = _factors(picture, level, alpha, beta)
        factors = own if factors is None else _enlarged(factors, own.shape) * own
    result: Values = factors.astype(logs.dtype)
    return result


def _pyramid(picture: Values) -> Iterator[Values]:
    """The picture, and again and again one of half the size, made of means of 2 x 2 pixels."""
    yield picture
    while min(picture.shape) >= 2 * SMALLEST:
        even: Any = np.pad(picture, [(0, length % 2) for length in picture.shape], mode="edge")
        picture = (even[::2, ::2] + even[1::2, ::2] + even[::2, 1::2] + even[1::2, 1::2]) / 4
        yield picture


def _factors(picture: Values, level: int, alpha: float, beta: float) -> Values:
    """(a / |grad|)^beta of one scale; central differences, per pixel of the finest scale."""
    inner: Any = np.pad(picture, 1, mode="edge")
    down, across = inner[2:, 1:-1] - inner[:-2, 1:-1], inner[1:-1, 2:] - inner[1:-1, :-2]
    norm = np.hypot(down, across) / 2 ** (level + 1)
    a = alpha * float(norm.mean(dtype=np.float64))
    if a == 0:
        return np.ones_like(picture)
    factors: Values = (a / np.maximum(norm, LEAST_NORM * a)) ** beta
    return factors


def _enlarged(picture: Values, shape: tuple[int, ...]) -> Values:
    """Twice the size, linearly interpolated between the middles of pixels."""
    for axis, length in enumerate(shape):
        picture = np.moveaxis(picture, axis, 0)
        padded: Any = np.pad(picture, ((1, 1), (0, 0)), mode="edge")
        twice = np.empty((2 * len(picture), picture.shape[1]), picture.dtype)
        twice[::2] = 0.75 * picture + 0.25 * padded[:-2]
        twice[1::2] = 0.75 * picture + 0.25 * padded[2:]
        picture = np.moveaxis(twice[:length], 0, axis)
    return picture
