"""The slowest mode of a region, and with it the best relaxation factor.

Jacobi's iteration on A contracts its slowest mode by mu = 1 - lambda, where lambda is the smallest eigenvalue of
A v = lambda D v and D the diagonal of A.  Red-black Gauss-Seidel with over-relaxation is fastest (Young 1954) with

    omega = 2 / (1 + sqrt(1 - mu^2))

and sensitive to it: a little too small costs far more sweeps than a little too large.  Rules of thumb by the number of
unknowns hold on round regions only, so lambda is computed here, on the region itself, by inverse iteration: each
step is an F-cycle on one channel, and a handful of them costs what a few sweeps cost.
"""

import math

import numpy as np

from solvers.cycles import Cycling
from solvers.hierarchy import Hierarchy
from solvers.kernels.exact import subtract_image
from solvers.layout import Float32, aligned_zeros, field_size
from solvers.team import Team

STEPS = 6  # the Rayleigh quotient's error shrinks by about 0.15 per step; the guess is good from the start

# The quotient approaches lambda from above, and a factor that is too small is the dear mistake.
CAUTION = 0.97


def smallest_eigenvalue(hierarchy: Hierarchy, team: Team) -> float:
    """lambda of A v = lambda D v: the smallest one, from above, to about a percent."""
    h = hierarchy
    diagonal = h.diagonal[: h.finest_size]
    size = field_size(h.table, 1)
    x, b = aligned_zeros(size), aligned_zeros(size)
    v, image = x[: h.finest_size], b[: h.finest_size]
    cycling = Cycling(h, "F", 1, team)
    v[:] = h.weight[: h.finest_size] > 0
    eigenvalue = 1.0
    for _ in range(STEPS):
        v /= np.float32(math.sqrt(_dot(v, diagonal * v)))
        image[:] = diagonal * v
        target = image.copy()
        v /= np.float32(eigenvalue)  # what A^-1 D v would be if v were the mode: the cycle mends the rest
        for _ in cycling.run(x, b):
            pass
        subtract_image(b, x[:0], x, h.diagonal, h.finest_segments, h.table, 1, False)
        eigenvalue = _dot(v, target - image) / _dot(v, diagonal * v)
    return eigenvalue


def softness(hierarchy: Hierarchy) -> float:
    """max A^-1 1, about 1 / the smallest eigenvalue of A: how far right-hand sides of size 1 can move the solution.

    R^2 / 4 in a disk of radius R, next to nothing in thin strokes, and more than the number of unknowns where a single
    pixel is known.  Taken from the coarsest level, as if its cells were all made of equally many pixels: right within
    a factor of three where it is large, too large in regions of small parts, where it is small.
    """
    return hierarchy.coarsest.softness * hierarchy.unknowns[0] / max(1, hierarchy.unknowns[-1])


def best_omega(hierarchy: Hierarchy, team: Team) -> float:
    """The relaxation factor that red-black SOR needs fewest sweeps with, on this region."""
    if hierarchy.unknowns[0] == 0:
        return 1.0
    smallest = CAUTION * min(1.0, smallest_eigenvalue(hierarchy, team))
    return 2 / (1 + math.sqrt(smallest * (2 - smallest)))  # 1 - mu^2 with mu = 1 - lambda


def _dot(a: Float32, b: Float32) -> float:
    return float(np.sum(a * b, dtype=np.float64))
