"""One clone to be done: the pictures, the region, and the exact answer to hold every tool against."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from benchmarks import exact, pictures, shapes

Array = np.ndarray[Any, Any]

DIRECT_LIMIT = (
    300_000  # unknowns up to which the reference is a sparse direct solve; above, a proven refinement
)
PROVEN = 1e-5  # levels: what the reference must be proven to, wherever a proof exists
TIE = 1e-6  # levels: exact values this close to a half may be rounded either way


@dataclass(frozen=True, eq=False)
class Case:
    """Clone `source` into `destination` over `region`, at offset (0, 0)."""

    name: str
    destination: Array  # (H, W, 3) uint8
    source: Array  # (H, W, 3) uint8
    region: Array  # (H, W) bool, True = unknown

    @property
    def unknowns(self) -> int:
        return int(self.region.sum())

    @property
    def system(self) -> exact.LinearSystem:
        """Built anew each time it is asked for: it is large."""
        return exact.LinearSystem.of_clone(self.destination, self.source, self.region)

    @cached_property
    def exact(self) -> Array:
        """f at the unknowns, in the order of `region.nonzero()`: (n, 3) float64, not clipped."""
        if self.unknowns <= DIRECT_LIMIT:
            system = self.system
            w = exact.solve_directly(system)
            bound = system.error_bound(system.residual(w))
            if bound > PROVEN:
                raise ArithmeticError(f"the direct solution is proven to {bound:.1e} levels only")
            return system.source + w
        values = np.empty((self.unknowns, self.source.shape[2]))
        for channel in range(values.shape[1]):  # one at a time: the pictures may be huge
            only = slice(channel, channel + 1)
            one = exact.LinearSystem.of_clone(
                self.destination[..., only], self.source[..., only], self.region
            )
            values[:, only] = one.source + exact.solve_by_refinement(one, _multigrid, bound=PROVEN)
        return values

    @property
    def out_of_range(self) -> float:
        """Share of the exact values that lie below 0 or above 255, and are clipped in a picture."""
        return float(((self.exact < 0) | (self.exact > 255)).mean())

    @property
    def pasted_rms(self) -> float:
        """Rms error, in levels, of pasting the source as it is: what no tool may be worse than."""
        error = self.source[self.region] - np.clip(self.exact, 0, 255)
        return float(np.sqrt(np.mean(error * error)))

    def picture(self, values: Array) -> Array:
        """The destination with `values` (n, 3), rounded and clipped, at the unknowns: (H, W, 3) uint8."""
        out = self.destination.copy()
        out[self.region] = np.clip(np.rint(values), 0, 255).astype(np.uint8)
        return out


def of_region(region: Array, name: str) -> Case:
    """The two photographs in the region's own frame."""
    return Case(name, pictures.destination(*region.shape), pictures.source(*region.shape), region)


def paper() -> Case:
    """The paper's: a disk of 60,000 pixels, in colour, in the middle of 512 x 512."""
    disk = shapes.disk_of(60_000)
    region = np.zeros((512, 512), bool)
    row, col = ((512 - side) // 2 for side in disk.shape)
    region[row : row + disk.shape[0], col : col + disk.shape[1]] = disk
    return of_region(region, "paper")


def _multigrid(region: Array, right_hand_side: Array) -> Array:
    """Our own solver, only as a step that `exact.solve_by_refinement` proves afterwards."""
    from solvers import PoissonProblem, solve_multigrid

    problem = PoissonProblem(
        region, np.zeros(region.shape, np.float32), rhs=right_hand_side.astype(np.float32)
    )
    return np.asarray(solve_multigrid(problem, threads=1).solution, np.float64)
