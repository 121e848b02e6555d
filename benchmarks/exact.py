"""The exact solution of eq. (7), and a proof of how exact it is.  Numpy and scipy only: nothing of ours.

Perez et al. 2003, eq. (7), for an unknown pixel p with 4-neighbours N_p inside the image:

    sum over q in N_p of (f_p - f_q)  =  sum over q in N_p of v_pq

The left side, at every pixel of the image, is `minus_laplacian(f)`.  For a clone v_pq = g_p - g_q, so the right
side is `minus_laplacian(g)`, and w = f - g solves `minus_laplacian(w) = 0` in the region with w = f* - g around
it.  Everything here works on w.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import scipy.sparse as sp
import scipy.sparse.linalg as spla

Array = np.ndarray[Any, Any]

ABOUT = 100.0  # levels: the size to which a correction is blown up before a solver with a tolerance sees it


def minus_laplacian(f: Array) -> Array:
    """Sum over q in N_p of f_p - f_q, at every pixel of an image (H, W) or (H, W, C)."""
    out = np.zeros_like(f)
    down = f[:-1] - f[1:]
    out[:-1] += down
    out[1:] -= down
    across = f[:, :-1] - f[:, 1:]
    out[:, :-1] += across
    out[:, 1:] -= across
    return out


def crop_of(region: Array) -> tuple[slice, slice]:
    """Bounding box of the region and one pixel around it, as far as the image goes."""
    box = []
    for axis in (1, 0):
        hit = np.flatnonzero(region.any(axis))
        box.append(slice(max(hit[0] - 1, 0), hit[-1] + 2))
    return box[0], box[1]


@dataclass(frozen=True, eq=False)
class LinearSystem:
    """A w = b for a clone: one matrix, one column of `b` per channel, unknowns in the order of `region.nonzero()`."""

    region: Array  # (h, w) bool, cropped
    known: Array  # (h, w, C) float64: f* - g
    source: Array  # (n, C) float64: g at the unknowns

    @classmethod
    def of_clone(cls, destination: Array, source: Array, region: Array) -> LinearSystem:
        """`destination`, `source`: (H, W, C), any dtype; `region`: (H, W) bool, True = unknown."""
        crop = crop_of(region)
        region = region[crop]
        g = source[crop].astype(np.float64)
        return cls(region, destination[crop] - g, g[region])

    @cached_property
    def matrix(self) -> sp.csr_matrix:
        """n x n: |N_p| on the diagonal, -1 for every pair of neighbouring unknowns."""
        height, width = self.region.shape
        index = np.cumsum(self.region, dtype=np.int32).reshape(height, width) - 1
        degree = np.full((height, width), 4.0)
        for edge in (degree[0], degree[-1], degree[:, 0], degree[:, -1]):
            edge -= 1.0  # right even if the crop does not reach the image's edge: only known pixels lie there then
        pairs = []
        for a, b in (
            ((slice(None), slice(-1)), (slice(None), slice(1, None))),
            ((slice(-1),), (slice(1, None),)),
        ):
            joined = self.region[a] & self.region[b]
            pairs.append((index[a][joined], index[b][joined]))
        p, q = (np.concatenate(side) for side in zip(*pairs, strict=True))
        n = len(self.source)
        upper = sp.coo_matrix((np.full(len(p), -1.0), (p, q)), (n, n)).tocsr()
        return (upper + upper.T + sp.diags(degree[self.region])).tocsr()

    @cached_property
    def right_hand_side(self) -> Array:
        """(n, C): the known neighbours' f* - g, summed."""
        around = np.where(self.region[..., None], 0.0, self.known)
        return -minus_laplacian(around)[self.region]

    def residual(self, w: Array) -> Array:
        """b - A w in float64, (n, C), from the image and not from the matrix."""
        field = self.known.copy()
        field[self.region] = w
        return -minus_laplacian(field)[self.region]

    def error_bound(self, residual: Array) -> float:
        """No entry of w is further than this from the exact solution (discrete maximum principle).

        The paraboloid z_p = (R^2 - |p - c|^2) / 4 has `minus_laplacian(z) = 1` and is not negative wherever
        |p - c| <= R.  With R reaching every known neighbour, z >= A^-1 1, so |A^-1 r| <= max|r| max z = max|r| R^2 / 4.
        A region that touches the image's edge has no such z: NaN.
        """
        region = self.region
        if region[0].any() or region[-1].any() or region[:, 0].any() or region[:, -1].any():
            return float("nan")
        radius_squared = sum(((side - 1) / 2) ** 2 for side in region.shape)
        return float(abs(residual).max() * radius_squared / 4)


def factorised(matrix: sp.csr_matrix) -> Callable[[Array], Array]:
    """A sparse direct solver, with the ordering and pivoting that suit a symmetric, diagonally dominant matrix."""
    factors = spla.splu(
        matrix.tocsc(), permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True}
    )
    solve: Callable[[Array], Array] = factors.solve
    return solve


def solve_directly(system: LinearSystem) -> Array:
    """w to rounding: sparse direct, then one step of refinement on the residual of the image."""
    solve = factorised(system.matrix)
    w = solve(system.right_hand_side)
    return w + solve(system.residual(w))


def solve_by_refinement(
    system: LinearSystem, approximate: Callable[[Array, Array], Array], *, bound: float, rounds: int = 8
) -> Array:
    """w (n, 1) of one channel from a solver that need not be trusted: refined until `error_bound` proves it.

    Parameters
    ----------
    approximate
        (region, right-hand side) -> roughly A^-1 of it; arrays (h, w) and (h, w).
    bound
        Largest error allowed, in levels.

    Raises
    ------
    ArithmeticError
        No proof after `rounds` rounds.
    """
    region = system.region
    w = np.zeros((len(system.source), 1))
    scale = 1.0
    for _ in range(rounds):
        residual = system.residual(w)
        proven = system.error_bound(residual)
        if proven <= bound:
            return w
        field = np.zeros(region.shape)
        field[region] = scale * residual[:, 0]
        correction = approximate(region, field)[region]
        w[:, 0] += correction / scale
        size = abs(correction).max() / scale  # the next correction is smaller, by what the solver achieves
        scale = ABOUT / max(size * 1e-4, 1e-300)
    raise ArithmeticError(f"the reference is proven to {proven:.1e} levels only, not to {bound:.1e}")
