"""The stop rule, stated once.

An iteration that contracts the error by rho a step, |e_k| <= rho |e_(k-1)|, moves by x_k - x_(k-1) = e_(k-1) - e_k, so

    |e_k| <= rho / (1 - rho) * max|x_k - x_(k-1)|        and we stop when the right side is <= tolerance

in the maximum norm: `tolerance` is the largest error allowed in any pixel.  rho is observed, as the ratio of successive
changes, and never believed to be below a floor, because a lucky ratio must not end a solve.  Errors that vanish slowly
are what is left of all errors after a while: a ratio that rises is taken to rise on (`next_rate`).  A residual norm
says nothing of this kind: the residual of a smooth error is smaller than the error by the square of the region's width.

The residual does give a bound from below, |e| >= max|r| / (8 + s), for no row of A, screened by s, sums to more than
8 + s in absolute value.
It is computed anew, in float64, before success is claimed: whatever the iteration believes, it cannot hide a residual.
`solvers.certificate` gives a bound from above that is proven, for the price of another solve.
"""

import math

from solvers.problem import OptionError

# In levels (1/255 of full scale).  Of evenly spread values, the share that is rounded to another 8-bit integer than
# the exact one is the mean error.  A smooth error, the last to go, has half its largest value on average: 1e-4 then,
# so that 99.99 % of the values are those of a direct solver.
DEFAULT_TOLERANCE = 2e-4

# A row of A holds the number of neighbours once and -1 for each of them, 4 + 4 at most, beside the screening.
LARGEST_ROW_SUM = 8.0

# A rate rises at most so much from one step to the next, as measured,
LARGEST_GROWTH = 2.0
# and one that is this slow already is near its last value.
SLOW = 0.5


def rate(changes: list[float]) -> float | None:
    """Contraction per step: the last change against the one before it; None where there is none before it."""
    if len(changes) < 2:
        return None
    return changes[-1] / changes[-2] if changes[-2] > 0 else 0.0


def next_rate(rates: list[float]) -> float:
    """What to expect of the next step: the slower one of the last two rates, or more if they rise; 0 without any."""
    last = rates[-2:]
    if len(last) < 2 or not 0 < last[0] < last[1]:
        return max(last, default=0.0)
    growth = min(last[1] / last[0], LARGEST_GROWTH)
    return max(last[1], min(last[1] * growth, SLOW))


def estimate(change: float, rho: float) -> float:
    """rho / (1 - rho) * change; infinite where nothing contracts."""
    if change == 0.0:
        return 0.0
    return change * rho / (1 - rho) if rho < 1 else math.inf


def check_tolerance(tolerance: float) -> float:
    """`tolerance` as a float; OptionError unless it is a positive number."""
    if not (math.isfinite(tolerance) and tolerance > 0):
        raise OptionError(f"tolerance is {tolerance}, but must be a positive number of levels")
    return float(tolerance)


def check_iterations(max_iterations: int | None, default: int) -> int:
    """`max_iterations`, or the default; OptionError unless it is positive."""
    if max_iterations is None:
        return default
    if max_iterations < 1:
        raise OptionError(f"max_iterations is {max_iterations}, but must be at least 1")
    return int(max_iterations)
