"""How far a solution can be from the exact one: proven, where `solvers.tolerance` only estimates.

Theorem.  Let A f = b be eq. (7), with some pixel known.  For any picture f', any delta that is zero on known pixels,
and any z >= 0 with A z >= |b - A f' - A delta| at every unknown pixel, no pixel of f' is further from f than
|delta| + z there.  (A may be screened: what is added to its diagonal only helps.)

Proof.  w = f - f' - delta is zero on known pixels, and A (z - w) >= 0, A (z + w) >= 0.
A picture g that is zero on known pixels and has A g >= 0 is nowhere negative: where it is least, no neighbour is larger
than it unless A g < 0, so its neighbours are as small, and theirs, until a known pixel is reached and least means 0.
Hence |w| <= z, and |f - f'| = |delta + w| <= |delta| + z.                                                     []

Any solver may propose delta and z, well or badly: what it proposes is checked here, in float64 and pixel by pixel, and
nothing else of it is believed.  A bad proposal gives a bound that is too large, never one that is too small.  delta is
about the error itself, signs and all, so that z has to cover only what is left; with delta = 0 a residual of
rounding errors, which mostly cancel, would count as if all its signs were alike.

Where no pixel is known, A z >= ... has no solution, for the rows of A sum to zero, but f is held by its mean.  A
pixel p is taken as known for z, so that |w - w_p| <= z.  Then w is nowhere further from its mean than z + mean(z):
that takes the place of z, and the mean of f - f', which is known, is added.
"""

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from solvers.canvas import Arrays, Values, with_channels
from solvers.problem import PoissonProblem

Float64 = NDArray[np.float64]
Solver = Callable[[PoissonProblem, int], Values]
"""An approximate solution, by so many iterations."""

EFFORTS = (5, 10, 20)  # iterations of the solver for one proposal, more of them
LOOSE = 0.2  # as long as z makes up more than this share of the bound
PROPOSALS = 4  # for z, each beginning where the last one ended
MARGIN = 0.25  # by how much of its mean the right side of A z = ... is raised, so that a z that is nearly right will do
ENOUGH = 0.75  # a z that covers at least this share of what it should is scaled up; else another is asked for

# Values that are computed at a time: they stay in the cache, and an interrupt is soon noticed.
BAND = 1 << 18

MEAN_EPS = 64 * np.finfo(np.float64).eps  # numpy adds pairwise, after eight at a time in blocks of 128
EPS = (
    1.01 * np.finfo(np.float64).eps / 2
)  # of one rounding, with room for the roundings of these bounds themselves


def proven_error(problem: PoissonProblem, precise: Values, stored: NDArray[Any], solver: Solver) -> float:
    """No value of `stored` is further than this from the exact solution, in levels; rounding errors included.

    Parameters
    ----------
    problem : PoissonProblem
    precise : (H, W[, C]) float64
        A solution before it was rounded to the type of the values.
    stored : (H, W[, C])
        The solution that the bound is for.  If it is a picture of integers, the bound is for what was rounded to them.
    solver : callable
        Need not be right.

    Returns
    -------
    float
        Infinity if the solver's proposals prove nothing.
    """
    precise = np.asarray(precise, np.float64)
    rounding = _storage_error(problem, precise, stored)
    best = np.inf
    for iterations in EFFORTS:
        proven, loose = _proof(problem, precise, solver, iterations)
        best = min(best, proven)  # never a NaN, which proves nothing
        if loose <= LOOSE * proven < np.inf:
            break
    return (best + rounding) / problem.level


def _proof(problem: PoissonProblem, precise: Float64, solver: Solver, iterations: int) -> tuple[float, float]:
    """max(|delta| + z), and max z: what a better proposal for delta could take off it."""
    region = problem.region
    solution = precise.reshape(*region.shape, -1)
    rounding = 0.0  # of what is computed for `rest`
    error = np.zeros(region.shape)  # largest |delta| of any channel
    rest = np.zeros(region.shape)  # largest |b - A f' - A delta| of any channel
    offset = 0.0  # of the mean, where that is what holds f
    for channel in range(problem.channels):
        r, blurred = _residual(problem, solution, channel)
        delta = _proposal(region, r, solver, iterations, problem.screening)
        if problem.floating:
            delta -= delta.mean()
            guess = problem.values.reshape(solution.shape)[..., channel]
            drift = guess.mean(dtype=np.float64) - solution[..., channel].mean()
            offset = max(offset, abs(float(drift)) + MEAN_EPS * (_size(guess) + _size(delta)))
        blurred += _add_minus_image(r, delta) + _subtract_drawn(r, delta, problem.screening)
        rounding = max(rounding, blurred)
        np.maximum(error, np.abs(delta), out=error)
        np.maximum(rest, np.abs(r), out=rest, where=region)

    if problem.floating:
        region = _one_held(region)
    rest += rounding
    rest[~region] = 0.0
    z = cover(region, rest, solver, problem.screening)
    if problem.floating:
        offset += float(z.mean())
    return float((error + z).max()) + offset, float(z.max())


def cover(region: NDArray[np.bool_], rest: Float64, solver: Solver, screening: float = 0.0) -> Float64:
    """Some z >= 0 with A z >= `rest` > 0 on the region, verified; infinite if none was found.  A is screened.

    Nothing needs to be verified for z >= 0: it follows from A z >= 0, as in the theorem.
    """
    if not region.any() or not rest.any():
        return np.zeros(region.shape)
    raised = np.where(region, rest + MARGIN * float(rest[region].mean()), 0.0)
    z = np.zeros(region.shape)
    for _ in range(PROPOSALS):
        missing = raised.copy()
        _add_minus_image(missing, z)
        _subtract_drawn(missing, z, screening)
        z += _proposal(region, missing, solver, EFFORTS[0], screening)
        image = np.zeros(region.shape)
        rounding = _add_minus_image(image, z) + _subtract_drawn(image, z, screening)
        covered = -image - rounding
        share = float(np.min(covered / np.where(region, rest, 1.0), where=region, initial=np.inf))
        if share >= ENOUGH:
            break
    if not share > 0:
        return np.full(region.shape, np.inf)
    return z / (share * (1 - 8 * EPS))


def _proposal(
    region: NDArray[np.bool_], rhs: Float64, solver: Solver, iterations: int, screening: float
) -> Float64:
    """About the solution of A u = `rhs` with u = 0 on known pixels; zero there, and finite."""
    size = float(np.max(np.abs(rhs), where=region, initial=0.0))
    if not 0 < size < np.inf:
        return np.zeros(region.shape)
    problem = PoissonProblem(region, np.zeros(region.shape), rhs=rhs / size, screening=screening)
    u = np.where(region, solver(problem, iterations) * size, 0.0)
    return u if np.isfinite(u).all() else np.zeros(region.shape)


def _residual(problem: PoissonProblem, solution: Float64, channel: int) -> tuple[Float64, float]:
    """b - A f' of one channel, (H, W), where the region is True, and a bound of its rounding errors.

    `solution` is (H, W, C).
    """
    region, guidance, screening = problem.region, problem.guidance, problem.screening
    r, rounding = np.zeros(region.shape), 0.0
    if problem.rhs is not None:
        r += problem.rhs.reshape(solution.shape)[..., channel]
        if problem.floating:
            rounding = 2 * MEAN_EPS * _size(r)
            r -= r.mean()  # as the solvers do: a natural condition all round has a solution only then
    across = down = None
    if guidance is not None:
        across, down = (with_channels(part)[..., channel] for part in (guidance.across, guidance.down))
    rounding += _add_minus_image(r, solution[..., channel], across, down)
    if screening > 0:
        moved = solution[..., channel] - problem.values.reshape(solution.shape)[..., channel]
        rounding += _subtract_drawn(r, moved, screening) + EPS * screening * _size(moved)
    r[~region] = 0.0
    return r, rounding


def _add_minus_image(
    r: Float64, f: Float64, across: Values | None = None, down: Values | None = None
) -> float:
    """r_p += sum over q in N_p of v_pq - (f_p - f_q), with v = 0 if it is not given; all (H, W).

    Returns a bound of the rounding errors of any pixel: four differences of f, and as many of v and those, are rounded,
    and four sums, of up to four of them and the r that was there before.
    """
    before, steepest, largest = _size(r), 0.0, 0.0
    for rows in _bands(f):
        below = slice(rows.start + 1, min(rows.stop, len(f) - 1) + 1)
        above = slice(rows.start, below.stop - 1)
        for p, q, v in (((rows, slice(-1)), (rows, slice(1, None)), across), ((above,), (below,), down)):
            misfit = f[q] - f[p]
            steepest = max(steepest, _size(misfit))
            if v is not None:
                misfit += v[p[0]]
            largest = max(largest, _size(misfit))
            r[p] += misfit
            r[q] -= misfit
    return EPS * (4 * steepest + 14 * largest + 4 * before)


def _subtract_drawn(r: Float64, moved: Float64, screening: float) -> float:
    """r -= screening * moved, what draws to the first guess; returns a bound of the rounding errors."""
    if screening == 0:
        return 0.0
    r -= screening * moved
    return EPS * (2 * screening * _size(moved) + _size(r))


def _bands(f: NDArray[np.generic]) -> Iterator[slice]:
    """Ranges of rows."""
    step = max(1, BAND * len(f) // max(1, f.size))
    for first in range(0, len(f), step):
        yield slice(first, min(first + step, len(f)))


def _one_held(region: NDArray[np.bool_]) -> NDArray[np.bool_]:
    held = region.copy()
    held[region.shape[0] // 2, region.shape[1] // 2] = False
    return held


def _size(values: Values) -> float:
    """The largest absolute value; no temporary array."""
    return max(float(values.max()), -float(values.min())) if values.size else 0.0


def _storage_error(problem: PoissonProblem, precise: Float64, stored: NDArray[Any]) -> float:
    """How far rounding can have moved the solution from `precise` to the floating-point numbers that are returned."""
    if isinstance(problem.canvas, Arrays):
        return max(float(np.abs(stored[rows] - precise[rows]).max()) for rows in _bands(precise))
    if stored.dtype.kind != "f":
        return 0.0
    # A canvas may have added the correction to something else: that is rounded, and so is the sum.
    return 1.01 * float(np.finfo(stored.dtype).eps) / 2 * (_size(precise) + _size(stored))
