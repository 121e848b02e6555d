"""What f* and the picture a differ by on the boundary, f* - a: all that the solver is told about the destination.

Where an object of the destination touches the selection, the difference is unlike that of the other boundary pixels,
and bleeds into Omega: a membrane carries it inwards.  Such pixels are outliers.  They can be made to count less by
winsorising: their difference is drawn back to where outliers begin.  The picture itself is not changed, so that a hard
edge remains at them, which is what a touching object should have.
"""

from typing import Any, NamedTuple

import numpy as np

from solvers.canvas import Values

# A difference is an outlier if it is further from the median than this many standard deviations,
DEVIATIONS = 3.0
# which are this many medians of the distances from the median, as in a normal distribution.
DEVIATION_PER_MEDIAN = 1.4826

# Boundary pixels that are looked at for the share of outliers; of more, every so manieth.
SAMPLE = 1 << 14


class Mismatch(NamedTuple):
    """What is told of the boundary, before anything is done about it; computed when asked for.

    Attributes
    ----------
    stored : (n, C)
        f* - g at the boundary's pixels that lie on the source, in stored values.
    stored_level : float
        The size of a level there.
    working : (m, C)
        f* - a at all of the boundary's pixels, in working values.
    working_level : float
    """

    stored: Values
    stored_level: float
    working: Values
    working_level: float

    def means(self) -> tuple[tuple[float, ...] | None, tuple[float, ...] | None]:
        """Per channel, the means of |f* - g| and of f* - g, in levels; None where no pixel has a source."""
        if len(self.stored) == 0:
            return None, None
        by_channel = np.ascontiguousarray(self.stored.T, np.float64)  # sums along rows are the fast ones
        shift = by_channel.mean(1) / self.stored_level
        mismatch = np.abs(by_channel).mean(1) / self.stored_level
        return tuple(mismatch.tolist()), tuple(shift.tolist())

    def outliers(self) -> float | None:
        """The share of outliers among the pixels, or some of them; None where there are none."""
        if len(self.working) == 0:
            return None
        some = self.working[:: 1 + len(self.working) // SAMPLE]
        return float(np.mean(outlyingness(some, self.working_level) > 1))


NOTHING = Mismatch(np.empty((0, 1), np.float32), 1.0, np.empty((0, 1), np.float32), 1.0)


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
