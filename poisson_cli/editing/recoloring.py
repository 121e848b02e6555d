"""Other colours for a picture (Fig. 11)."""

import numpy as np

from poisson_cli.editing import colour
from poisson_cli.editing.layers import Look
from poisson_cli.editing.numbers import LARGEST_FACTOR, check_number
from poisson_cli.errors import InputError
from solvers.canvas import Values


def recoloring(gain: tuple[float, float, float], hue: float, saturation: float, full: float) -> Look | None:
    """What multiplies R, G, B by `gain`, then turns hues by `hue` degrees and multiplies chroma by `saturation`.

    Hue and chroma are CIE-Lab's, where they do not touch the lightness that one sees: turning the hue of HSV would make
    a yellow object that becomes blue far darker as well.

    Parameters
    ----------
    full : float
        Full scale of stored values.

    Returns
    -------
    callable or None
        (..., 3) stored values -> the same, not clipped; None if nothing changes, to the last bit.

    Raises
    ------
    InputError
        If a parameter makes no sense.
    """
    factors = np.asarray(gain, np.float64)
    if factors.shape != (3,) or not ((factors >= 0) & (factors <= LARGEST_FACTOR)).all():
        raise InputError(
            f"gain is {gain}, but must be three numbers from 0 to {LARGEST_FACTOR:g}, for red, green and blue"
        )
    if not np.isfinite(hue):
        raise InputError(f"hue is {hue}, but must be a number of degrees")
    check_number("saturation", saturation, 0, LARGEST_FACTOR)
    turns = hue % 360 != 0 or saturation != 1
    if not turns and (factors == 1).all():
        return None
    angle = np.deg2rad(hue % 360)
    along, aside = saturation * float(np.cos(angle)), saturation * float(np.sin(angle))

    def recolored(stored: Values) -> Values:
        values: Values = stored * factors.astype(stored.dtype)
        if turns:
            lab = colour.lab_of(values / values.dtype.type(full))
            a, b = lab[..., 1].copy(), lab[..., 2].copy()
            lab[..., 1], lab[..., 2] = along * a - aside * b, aside * a + along * b
            values = colour.srgb_of(lab) * values.dtype.type(full)
        return values

    return recolored
