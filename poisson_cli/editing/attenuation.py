"""Eq. (16): large gradients made smaller and small ones larger, by the norm of a gradient of logarithms."""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from poisson_cli.editing.guidance import Factors
from poisson_cli.editing.layers import Band, Layer
from poisson_cli.editing.numbers import LARGEST_FACTOR, check_number
from solvers import Guidance
from solvers.canvas import Values, bands


def gradient_norms(picture: Values) -> Guidance:
    """|grad| at the middle of each pixel pair of an (n, w, c) picture.

    Along the pair it is the pair's own difference; the other way, the mean of the differences that its two pixels have
    with their neighbours, as many of the four as there are.  So the norm is that of a vector, and does not depend on
    how the grid lies: each pair by itself would take a slanting edge for several edges of different strength.
    """
    d = Guidance.of(picture)
    return Guidance(
        np.hypot(d.across, _at_pairs(d.down)),
        np.hypot(d.down, _at_pairs(d.across.swapaxes(0, 1)).swapaxes(0, 1)),
    )


def _at_pairs(down: Values) -> Values:
    """(n - 1, w, c) differences of rows, at the pairs of neighbours in each row: (n, w - 1, c)."""
    if len(down) == 0:  # a single row
        return np.zeros((1, down.shape[1] - 1, down.shape[2]), down.dtype)
    at_pixels: Any = np.concatenate((down[:1], (down[1:] + down[:-1]) / 2, down[-1:]))
    mean: Values = (at_pixels[:, 1:] + at_pixels[:, :-1]) / 2
    return mean


def attenuating(
    layers: Sequence[Layer], region: NDArray[np.bool_], *, alpha: float, beta: float, least: float = 0.0
) -> Factors:
    """Factors (a / |grad|)^beta, with a = alpha times the mean of |grad| over the pixel pairs that touch Omega.

    Parameters
    ----------
    layers : sequence of Layer
        In a log domain, of as many channels each; of several, the larger norm is taken.
    region : (h, w) bool
        Omega.
    alpha, beta : float
        As in eq. (16).
    least : float
        Norms below this times a are taken to be that.

    Raises
    ------
    InputError
        If `alpha` is not positive or above 1000, or `beta` not in -1...1: above 1 gradients of nothing would become
        infinite, and below -1 those of edges almost so.
    """
    check_number("alpha", alpha, 0, LARGEST_FACTOR, above_low=True)
    check_number("beta", beta, -1, 1)

    def norms(first: int, end: int) -> Guidance:
        # With memory of its own: threads ask at the same time.
        found = [gradient_norms(layer.apart().rows(first, end)) for layer in layers]
        across, down = found[0].across, found[0].down
        for other in found[1:]:
            np.maximum(across, other.across, out=across)
            np.maximum(down, other.down, out=down)
        return Guidance(across, down)

    channels = layers[0].channels
    scale = alpha * _mean_at_pairs(norms, region, channels)

    def factors(band: Band) -> Guidance:
        n = norms(*band.rows)
        return Guidance(_power(n.across, scale, beta, least), _power(n.down, scale, beta, least))

    return factors


def _power(norm: Values, a: NDArray[np.float64], beta: float, least: float) -> Values:
    """(a / norm)^beta; `norm` is written into."""
    scale: Any = a.astype(norm.dtype)
    np.maximum(norm, least * scale, out=norm)
    norm[norm == 0] = 1  # what is multiplied there is zero
    factor: Values = (np.where(scale > 0, scale, 1) / norm) ** norm.dtype.type(beta)
    return factor


def _mean_at_pairs(
    norms: Callable[[int, int], Guidance], region: NDArray[np.bool_], channels: int
) -> NDArray[np.float64]:
    """Per channel, the mean over all pairs with a pixel in Omega.  Added up row by row: bands make no difference."""
    height, width = region.shape
    sums: tuple[list[Any], list[Any]] = ([], [])
    pairs = 0
    for first, end in bands(0, height, width * channels):
        top, bottom = max(first - 1, 0), min(end + 1, height)
        n, r = norms(top, bottom), region[top:bottom]
        mine = slice(first - top, end - top)
        touching = r[:, :-1] | r[:, 1:], r[:-1] | r[1:]
        for rows, part, touches in zip(sums, (n.across, n.down), touching, strict=True):
            pairs += int(np.count_nonzero(touches[mine]))
            counted = np.where(touches[mine, :, np.newaxis], part[mine], 0)
            rows += [row.sum(0, dtype=np.float64) for row in counted]
    total: NDArray[np.float64] = np.sum(sums[0] + sums[1], axis=0)
    return total / max(pairs, 1)
