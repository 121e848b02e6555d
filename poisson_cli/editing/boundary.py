"""What f* and the picture a differ by on the boundary, f* - a: all that the solver is told about the destination.

Where an object of the destination touches the selection, the difference is unlike that of the other boundary pixels,
and bleeds into Omega: a membrane carries it inwards.  Such pixels are outliers.  They can be made to count less by
winsorising: their difference is drawn back to where outliers begin.  The picture itself is not changed, so that a hard
edge remains at them, which is what a touching object should have.
"""

from typing import Any

import numpy as np

from solvers.canvas import Values

# A difference is an outlier if it is further from the median than this many standard deviations,
DEVIATIONS = 3.0
# which are this many medians of the distances from the median, as in a normal distribution.
DEVIATION_PER_MEDIAN = 1.4826


def outlyingness(difference: Values, level: float) -> Values:
    """Per boundary pixel, its distance from the median as a multiple of that at which outliers begin.

    Parameters
    ----------
    difference : (n, C)
        f* - a at boundary pixels, n >= 1.
    level : float
        A level in working units: distances of a level or less are never outliers.

    Returns
    -------
    (n,) float
        That of the channel in which it is largest; above 1 for outliers.
    """
    by_channel: Any = np.ascontiguousarray(difference.T)  # medians along rows are the fast ones
    distance: Values = np.abs(by_channel - _median(by_channel))
    usual = DEVIATION_PER_MEDIAN * _median(distance)
    distance /= DEVIATIONS * np.maximum(usual, level / DEVIATIONS)
    far: Values = distance.max(0)
    return far


def winsorised(difference: Values, level: float) -> Values:
    """The differences, (n, C), with outliers drawn towards the median, in a straight line, to where outliers begin."""
    middle = _median(difference.T)[:, 0]
    far: Any = np.maximum(outlyingness(difference, level), 1)[:, np.newaxis].astype(difference.dtype)
    drawn: Values = np.where(far > 1, middle + (difference - middle) / far, difference)
    return drawn


def _median(values: Values) -> Any:
    """Of (C, n) values, per channel, (C, 1).  `numpy.median` does the same and imports masked arrays for it: 6 ms."""
    n = values.shape[1]
    low, high = (n - 1) // 2, n // 2
    sorted_there: Any = np.partition(values, (low, high) if low < high else low, axis=1)
    return (sorted_there[:, low, np.newaxis] + sorted_there[:, high, np.newaxis]) / 2
