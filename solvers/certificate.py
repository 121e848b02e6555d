"""How far a solution can be from the exact one: proven, where `solvers.tolerance` only estimates.

Theorem.  Let A f = b be eq. (7), with some pixel known.  For any picture f', any delta that is zero on known pixels,
and any z >= 0 with A z >= |b - A f' - A delta| at every unknown pixel, no pixel of f' is further from f than
|delta| + z there.

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

import numpy as np
from numpy.typing import NDArray

from solvers.problem import PoissonProblem, Values

Float64 = NDArray[np.float64]
Solver = Callable[[PoissonProblem, int], Values]
"""An approximate solution, by so many iterations."""

ITERATIONS = 5  # of the solver, for one proposal
PROPOSALS = 4  # for z, each beginning where the last one ended
MARGIN = 0.25  # by how much of its mean the right side of A z = ... is raised, so that a z that is nearly right will do
ENOUGH = 0.75  # a z that covers at least this share of what it should is scaled up; else another is asked for

# Values that are computed at a time: they stay in the cache, and an interrupt is soon noticed.
BAND = 1 << 18

# A residual is a sum of at most four differences (of a v and two f) and a right-hand side: 13 rounded operations, none
# of them on more than all the terms together.  And some room for the roundings of these very bounds.
ROUNDINGS = 32 * np.finfo(np.float64).eps


def proven_error(problem: PoissonProblem, precise: Values, stored: Values, solver: Solver) -> float:
    """No value of `stored` is further than this from the exact solution, in levels; rounding errors included.

    Parameters
    ----------
    problem : PoissonProblem
    precise : (H, W[, C]) float64
        A solution before it was rounded to the type of the values.
    stored : (H, W[, C])
        The solution that the bound is for.  Both are the problem's values outside the region.
    solver : callable
        Need not be right.

    Returns
    -------
    float
        Infinity if the solver's proposals prove nothing.
    """
    region = problem.region
    precise = np.asarray(precise, np.float64)
    solution, channels = precise.reshape(*region.shape, -1), range(problem.channels)
    error = np.zeros(region.shape)  # largest |delta| of any channel
    rest = np.zeros(region.shape)  # largest |b - A f' - A delta| of any channel
    offset = 0.0  # of the mean, where that is what binds f
    for channel in channels:
        r = _residual(problem, solution, channel)
        delta = _proposal(region, r, solver)
        if problem.floating:
            delta -= delta.mean()
            guess = problem.values.reshape(solution.shape)[..., channel]
            drift = guess.mean(dtype=np.float64) - solution[..., channel].mean()
            offset = max(offset, abs(float(drift)) + ROUNDINGS * _size(guess))
        _add_minus_image(r, delta)
        np.maximum(error, np.abs(delta), out=error)
        np.maximum(rest, np.abs(r), out=rest, where=region)

    if problem.floating:
        region = _one_held(region)
    rest += ROUNDINGS * (_largest_term(problem, precise) + 2 * _size(error))
    rest[~region] = 0.0
    z = cover(region, rest, solver)
    if problem.floating:
        offset += float(z.mean())
    rounding = _largest_difference(stored, precise)
    bound = (float((error + z).max()) + offset + rounding) / problem.level
    return bound if bound < np.inf else np.inf  # a NaN proves nothing


def cover(region: NDArray[np.bool_], rest: Float64, solver: Solver) -> Float64:
    """Some z >= 0 with A z >= `rest` > 0 on the region, verified; infinite if none was found.

    Nothing needs to be verified for z >= 0: it follows from A z >= 0, as in the theorem.
    """
    if not region.any() or not rest.any():
        return np.zeros(region.shape)
    raised = np.where(region, rest + MARGIN * float(rest[region].mean()), 0.0)
    z = np.zeros(region.shape)
    for _ in range(PROPOSALS):
        missing = raised.copy()
        _add_minus_image(missing, z)
        z += _proposal(region, missing, solver)
        image = np.zeros(region.shape)
        _add_minus_image(image, z)
        covered = -image - ROUNDINGS * 2 * _size(z)
        share = float(np.min(covered / np.where(region, rest, 1.0), where=region, initial=np.inf))
        if share >= ENOUGH:
            break
    if not share > 0:
        return np.full(region.shape, np.inf)
    return z / (share * (1 - ROUNDINGS))


def _proposal(region: NDArray[np.bool_], rhs: Float64, solver: Solver) -> Float64:
    """About the solution of A u = `rhs` with u = 0 on known pixels; zero there, and finite."""
    size = float(np.max(np.abs(rhs), where=region, initial=0.0))
    if not 0 < size < np.inf:
        return np.zeros(region.shape)
    problem = PoissonProblem(region, np.zeros(region.shape), rhs=rhs / size)
    u = np.where(region, solver(problem, ITERATIONS) * size, 0.0)
    return u if np.isfinite(u).all() else np.zeros(region.shape)


def _residual(problem: PoissonProblem, solution: Float64, channel: int) -> Float64:
    """b - A f' of one channel, (H, W), where the region is True; `solution` is (H, W, C)."""
    region, guidance = problem.region, problem.guidance
    r = np.zeros(region.shape)
    if problem.rhs is not None:
        r += problem.rhs.reshape(solution.shape)[..., channel]
        if problem.floating:
            r -= r.mean()  # as the solvers do: a natural condition all round has a solution only then
    if guidance is None:
        _add_minus_image(r, solution[..., channel])
    else:
        across, down = (
            part.reshape(*part.shape[:2], -1)[..., channel] for part in (guidance.across, guidance.down)
        )
        _add_minus_image(r, solution[..., channel], across, down)
    r[~region] = 0.0
    return r


def _add_minus_image(
    r: Float64, f: Float64, across: Values | None = None, down: Values | None = None
) -> None:
    """r_p += sum over q in N_p of v_pq - (f_p - f_q), with v = 0 if it is not given; all (H, W)."""
    for rows in _bands(f):
        misfit = f[rows, 1:] - f[rows, :-1]
        if across is not None:
            misfit += across[rows]
        r[rows, :-1] += misfit
        r[rows, 1:] -= misfit
        below = slice(rows.start + 1, min(rows.stop, len(f) - 1) + 1)
        above = slice(rows.start, below.stop - 1)
        misfit = f[below] - f[above]
        if down is not None:
            misfit += down[above]
        r[above] += misfit
        r[below] -= misfit


def _bands(f: NDArray[np.generic]) -> Iterator[slice]:
    """Ranges of rows."""
    step = max(1, BAND * len(f) // max(1, f.size))
    for first in range(0, len(f), step):
        yield slice(first, min(first + step, len(f)))


def _one_held(region: NDArray[np.bool_]) -> NDArray[np.bool_]:
    held = region.copy()
    held[region.shape[0] // 2, region.shape[1] // 2] = False
    return held


def _largest_term(problem: PoissonProblem, precise: Float64) -> float:
    """What no difference v_pq - (f_p - f_q) and no right-hand side exceeds."""
    guidance = problem.guidance
    v = 0.0 if guidance is None else max(_size(guidance.across), _size(guidance.down))
    return v + 2 * _size(precise) + (0.0 if problem.rhs is None else 2 * _size(problem.rhs))


def _size(values: Values) -> float:
    """The largest absolute value; no temporary array."""
    return max(float(values.max()), -float(values.min())) if values.size else 0.0


def _largest_difference(a: Values, b: Float64) -> float:
    return max(float(np.abs(a[rows] - b[rows]).max()) for rows in _bands(b))
